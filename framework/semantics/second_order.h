// What the second order adds to first-order errors, found by moving sources and evaluating again.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "framework/semantics/error_draws.h"
#include "framework/semantics/perturbation.h"
#include "framework/semantics/principal_axes.h"

namespace ilss {

/// Sums over sources of what moving each does to an output along one direction.
struct Moments {
  double curvature = 0;          ///< of second differences
  double squared_curvature = 0;  ///< of their squares
  double secant_variance = 0;    ///< of squared central differences
  double mixed_variance = 0;     ///< second-order variance of sources moving together

  double bias() const { return curvature / 2; }
  double second_order_variance() const { return squared_curvature / 2 + mixed_variance; }
};

/// What moving its sources does to one output: along its components, and where there are several
/// along the principal axes of its covariance, too, since components alone would hide what happens
/// across a thin error ellipse.
struct SecondOrder {
  bool wanted = false;                    ///< set by who asks; what is not wanted is left alone
  PrincipalAxes axes = {};                ///< of the stated covariance
  std::vector<Moments> moments = {};      ///< of components, then axes
  bool meets_fault = false;               ///< a move led out of a function's domain
  bool changes_label = false;             ///< a move led to another case of a function
  std::vector<std::size_t> sources = {};  ///< that it is evaluated again for
};

/// Moves a perturbation's sources: each by ±sqrt(3) standard deviations, the points of third-order
/// Gauss-Hermite quadrature; then pairs by ±1, for outputs of up to `most_paired_sources`, or all
/// with random signs. An output's figures do not depend on which others are asked for beside it.
/// Keeps its buffers from one use to the next.
class SecondOrderSearch {
 public:
  static constexpr std::size_t most_paired_sources = 12;

  /// One entry of `outputs` a target, in order.
  void run(const System& system, Perturbation& perturbation, const ErrorDraws& draws,
           std::span<SecondOrder> outputs);

 private:
  using Offsets = std::vector<double>;  ///< along the directions, of one output after another

  void begin(const System& system);
  enum class Take { changed, all };
  void measure(Offsets& offsets, Take take = Take::changed);
  void move_each();
  void move_pairs();
  void move_together(const ErrorDraws& draws);
  template <typename Gather>
  void for_each_direction(std::size_t target, const Gather& gather);

  Perturbation* perturbation_ = nullptr;
  std::span<SecondOrder> outputs_;
  std::vector<std::size_t> first_;  ///< place of each output's first direction in Offsets
  std::vector<double> errors_;
  std::vector<double> offset_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  std::vector<std::uint64_t> signs_;
  Offsets a_, b_, c_, d_;
};

}  // namespace ilss
