// Lineage: how sensitive an estimate is to each independent source of error.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "framework/estimate/source.h"

namespace ilss {

/// The factor matrix G (M x K, column-major) of an M-dimensional estimate over K sources of unit
/// variance, sorted by source: covariance = G Gᵀ, so it is never indefinite. Buffers keep their
/// capacity, so reuse does not allocate.
class Lineage {
 public:
  explicit Lineage(std::size_t dimension = 0) : dimension_(dimension) {}

  /// Forgets every source; the estimate is exact until columns are added.
  void reset(std::size_t dimension) {
    dimension_ = dimension;
    sources_.clear();
    factor_.clear();
  }

  std::size_t dimension() const { return dimension_; }  ///< M
  std::size_t size() const { return sources_.size(); }  ///< K
  bool empty() const { return sources_.empty(); }
  std::span<const Source> sources() const { return sources_; }
  std::span<const double> column(std::size_t k) const {
    return {factor_.data() + k * dimension_, dimension_};
  }
  Eigen::Map<const Eigen::MatrixXd> factor() const {
    return {factor_.data(), static_cast<Eigen::Index>(dimension_),
            static_cast<Eigen::Index>(sources_.size())};
  }

  /// Adds a column; adds to it where the source is there already.
  void add(Source source, std::span<const double> column);
  /// Adds a column that is zero but for component i.
  void add(Source source, std::size_t component, double sensitivity);
  /// Adds the Cholesky factor of a noise covariance (M x M, positive semidefinite) as columns
  /// `first.column`, +1, ... of the owner; zero columns are left out.
  void add_noise(Source first, const Eigen::Ref<const Eigen::MatrixXd>& covariance);

  Eigen::MatrixXd covariance() const;
  /// The same into a matrix that is there already (M x M).
  void covariance(Eigen::Ref<Eigen::MatrixXd> out) const;
  double variance(std::size_t component) const;
  double standard_deviation(std::size_t component) const;

  /// Replaces columns that nothing else refers to by at most M of the same covariance (LQ), each
  /// owner's random and persistent ones apart, so that budgets survive and persistent errors still
  /// do not average out. `foldable` says which sources may go; `folder` (below 2^24) is unique to
  /// the place of folding, which folds once a tick, and keeps the new sources' names unique.
  /// Estimates of more than 64 components are left as they are.
  void fold(const std::function<bool(const Source&)>& foldable, std::uint32_t folder);
  /// As `fold`, but all foldable columns become at most M columns of one owner: random ones, unless
  /// all are persistent.
  void fold_together(const std::function<bool(const Source&)>& foldable, std::uint32_t folder,
                     std::uint32_t owner);

 private:
  friend void compose(std::span<const struct LineageTerm>, std::size_t, Lineage&);
  bool append_next(std::span<const struct LineageTerm> terms, std::span<std::size_t> next);
  template <typename Foldable>
  void fold_range(std::size_t begin, std::size_t end, const Foldable& foldable, Source first);

  std::size_t dimension_ = 0;
  std::vector<Source> sources_;
  std::vector<double> factor_;
};

/// One input of a linear map: its Jacobian (rows x lineage dimension, column-major) and lineage.
struct LineageTerm {
  const double* jacobian;
  const Lineage* lineage;
};

/// `out` = sum of J_i G_i with columns aligned by source; `rows` is the dimension of `out`, which
/// must not be one of the terms. Columns that vanish exactly are kept: dropping them would make the
/// cost of a tick depend on its values.
void compose(std::span<const LineageTerm> terms, std::size_t rows, Lineage& out);

/// As `compose` where the correlation of the terms' random errors is not known: `out` has a
/// covariance that is not below the true one, whatever it is, since Var(sum a_i) <= n sum Var(a_i)
/// (Cauchy-Schwarz). Random columns become new ones, `first` and on; persistent ones are shared as
/// the lineages say.
void compose_bounded(std::span<const LineageTerm> terms, std::size_t rows, Source first,
                     Lineage& out);

/// Cov(a, b) = G_a G_bᵀ over their common sources (M_a x M_b).
Eigen::MatrixXd cross_covariance(const Lineage& a, const Lineage& b);

}  // namespace ilss
