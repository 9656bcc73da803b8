// Estimates whose errors are drawn from their own lineages, for tests of fusion.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>

#include "framework/estimate/consistency.h"
#include "tests/sensors/module_run.h"

namespace ilss::test {

/// A robot's pose in the plane; its heading is on the circle.
template <typename T>
struct Pose {
  T x, z, heading;
  static constexpr std::string_view name = "pose";
  static constexpr auto fields =
      Fields{{"x", "m"}, {"z", "m"}, {"heading", "rad", "", required, Geometry::circular}};
};

template <typename T>
struct Length {
  T x;
  static constexpr std::string_view name = "length";
  static constexpr auto fields = Fields{{"x", "m"}};
};

/// One standard normal error for each source, the same whoever asks.
class Errors {
 public:
  explicit Errors(std::uint64_t seed) : random_(seed) {}
  double of(const Source& source) {
    const auto [place, fresh] = errors_.try_emplace(source, 0.0);
    if (fresh) place->second = draw_normal(random_);
    return place->second;
  }
  /// Moves one source by an amount that is added to its error, drawn or 0.
  void move(const Source& source, double amount) { errors_[source] += amount; }

 private:
  RandomBits random_;
  std::map<Source, double> errors_;
};

/// The estimate that these errors make of the truth.
inline Output drawn(const PayloadDescriptor& payload, const std::vector<double>& truth,
                    const Lineage& lineage, Errors& errors) {
  Output output;
  output.estimate = Estimate(payload);
  output.estimate.lineage = lineage;
  std::vector<double> made(truth.size(), 0.0);
  for (std::size_t k = 0; k < lineage.size(); ++k) {
    const double error = errors.of(lineage.sources()[k]);
    for (std::size_t c = 0; c < truth.size(); ++c) made[c] += error * lineage.column(k)[c];
  }
  output.estimate.value = retract(payload, truth, made);
  return output;
}

/// A lineage with a factor's columns as sources `owner`, 0, 1, ... at tick 0.
inline void add_columns(Lineage& lineage, std::uint32_t owner, const Eigen::MatrixXd& factor,
                        std::int64_t tick = 0) {
  for (Eigen::Index k = 0; k < factor.cols(); ++k) {
    const Eigen::VectorXd column = factor.col(k);
    lineage.add({owner, static_cast<std::uint32_t>(k), tick},
                std::span<const double>(column.data(), lineage.dimension()));
  }
}
inline Lineage lineage_of(std::uint32_t owner, const Eigen::MatrixXd& factor) {
  Lineage lineage(static_cast<std::size_t>(factor.rows()));
  add_columns(lineage, owner, factor);
  return lineage;
}

/// A lower triangular factor with entries drawn from [-1, 1], its diagonal from [0.5, 1].
inline Eigen::MatrixXd random_factor(Eigen::Index m, RandomBits& random) {
  const auto entry = [](RandomBits& bits) { return draw_uniform(bits, -1, 1); };
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index i = 0; i < m; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      factor(i, j) = i == j ? 0.75 + 0.25 * entry(random) : entry(random);
  return factor;
}

/// Lineages of two estimates of equal covariance F Fᵀ, correlated by sources that they share.
inline std::vector<Lineage> correlated_pair(double correlation, const Eigen::MatrixXd& factor) {
  std::vector<Lineage> pair;
  for (std::uint32_t i = 0; i < 2; ++i) {
    Lineage lineage(static_cast<std::size_t>(factor.rows()));
    if (correlation > 0) add_columns(lineage, 50, std::sqrt(correlation) * factor);
    add_columns(lineage, 51 + i, std::sqrt(1 - correlation) * factor);
    pair.push_back(lineage);
  }
  return pair;
}

/// What a module makes of these outputs.
inline ModuleRun run_on(Module& module, const std::vector<Output>& inputs, std::int64_t tick = 0) {
  Tick at;
  at.tick = tick;
  for (const Output& input : inputs) at.inputs.push_back(&input);
  return run(module, at);
}

inline const PayloadDescriptor& pose() { return descriptor<Pose>(); }
inline const PayloadDescriptor& length() { return descriptor<Length>(); }

/// A length with an error of its own.
inline Output length_of(double x, double standard_deviation, std::uint32_t owner) {
  return output_of<Length>({x}, {standard_deviation}, owner);
}

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double probability = 0.99;

}  // namespace ilss::test
