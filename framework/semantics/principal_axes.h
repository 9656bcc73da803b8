// The principal axes of an estimate's error, along which it has unit variance.
#pragma once

#include <span>
#include <vector>

#include "framework/estimate/lineage.h"

namespace ilss {

/// The principal axes of a covariance, judged on its correlation matrix since components may have
/// different units; directions without variance are left out, as in NEES. No allocation once warm.
class PrincipalAxes {
 public:
  /// Takes those of a lineage's covariance.
  void take(const Lineage& lineage);

  std::size_t rank() const { return dimension_ == 0 ? 0 : rows_.size() / dimension_; }
  /// The row (M) by which an offset becomes a number of unit variance along axis i.
  std::span<const double> axis(std::size_t i) const {
    return {rows_.data() + i * dimension_, dimension_};
  }
  /// An offset's squared distance in standard deviations, within the axes that are there.
  double squared_distance(std::span<const double> offset) const;
  /// What 95 % of normal errors do not exceed of it.
  double squared_radius_95() const;

 private:
  template <typename Matrix>
  void decompose(const Matrix& covariance);

  std::size_t dimension_ = 0;
  std::vector<double> rows_;
};

}  // namespace ilss
