#include "sensors/fusion/joint_deviations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "framework/estimate/decompositions.h"

namespace ilss {
namespace {

/// Standard deviations below this part of the scale are rounding.
constexpr double rank_tolerance = 1e-10;
/// Sine of the angle between constraints that are taken for one (11.5 degrees).
constexpr double nearest_constraints = 0.2;

/// The size of the numbers that a component was computed from, to which rounding is relative.
double size_of(std::span<const Output* const> inputs, const std::string& unit) {
  double size = 0;
  for (const Output* input : inputs)
    for (std::size_t c = 0; c < input->estimate.dimension(); ++c) {
      const Component& component = input->estimate.type->components[c];
      if (component.unit != unit) continue;
      size = std::max(size, std::abs(input->estimate.value[c]));
      if (component.geometry != Geometry::plain) size = std::max(size, std::numbers::pi);
    }
  return size;
}

/// The standard deviation of a component; 0 where it is but rounding of what cancelled.
double deviation_of(const Output& input, std::size_t component, double size) {
  constexpr double rounding = 1e-14;
  const double deviation = input.estimate.lineage.standard_deviation(component);
  return deviation > rounding * size ? deviation : 0;
}

Eigen::VectorXd scale_of(std::span<const Output* const> inputs) {
  const std::vector<Component>& components = inputs.front()->estimate.type->components;
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(components.size()));
  for (std::size_t c = 0; c < components.size(); ++c) {
    const double size = size_of(inputs, components[c].unit);
    double& component = largest[static_cast<Eigen::Index>(c)];
    for (const Output* input : inputs)
      component = std::max(component, deviation_of(*input, c, size));
  }
  Eigen::VectorXd scale = largest;
  for (std::size_t a = 0; a < components.size(); ++a)
    for (std::size_t b = 0; b < components.size(); ++b)
      if (components[a].unit == components[b].unit)
        scale[static_cast<Eigen::Index>(a)] =
            std::max(scale[static_cast<Eigen::Index>(a)], largest[static_cast<Eigen::Index>(b)]);
  return scale.unaryExpr([](double s) { return s > 0 ? s : 1.0; });
}

/// How an estimate ⊖ origin moves with its sources.
Eigen::MatrixXd factor_at(const Estimate& estimate, std::span<const double> origin) {
  if (is_flat(*estimate.type)) return estimate.lineage.factor();
  const Eigen::VectorXd apart = difference(estimate, origin);
  return difference_by_first(*estimate.type, std::span(apart.data(), estimate.dimension())) *
         estimate.lineage.factor();
}

JointEstimates lay_side_by_side(std::span<const Output* const> inputs,
                                std::span<const double> origin, bool separate_random) {
  const Estimate& first = inputs.front()->estimate;
  JointEstimates joint{static_cast<Eigen::Index>(inputs.size()),
                       static_cast<Eigen::Index>(first.dimension()),
                       scale_of(inputs),
                       {origin.begin(), origin.end()},
                       {},
                       {}};
  const Eigen::VectorXd inverse_scale = joint.scale.cwiseInverse();
  joint.offset.resize(joint.dimension, joint.count);
  std::vector<Source> shared;
  Eigen::Index apart = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Estimate& estimate = inputs[i]->estimate;
    joint.offset.col(static_cast<Eigen::Index>(i)) =
        difference(estimate, origin).cwiseProduct(inverse_scale);
    for (const Source& source : estimate.lineage.sources()) {
      if (separate_random && !source.persistent())
        ++apart;
      else
        shared.push_back(source);
    }
  }
  std::sort(shared.begin(), shared.end());
  shared.erase(std::unique(shared.begin(), shared.end()), shared.end());
  auto next_separate = static_cast<Eigen::Index>(shared.size());
  joint.factor.setZero(joint.count * joint.dimension, next_separate + apart);
  const double bound = std::sqrt(static_cast<double>(inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Lineage& lineage = inputs[i]->estimate.lineage;
    const Eigen::MatrixXd at_origin = factor_at(inputs[i]->estimate, origin);
    for (std::size_t k = 0; k < lineage.size(); ++k) {
      const Source& source = lineage.sources()[k];
      const bool is_separate = separate_random && !source.persistent();
      const Eigen::Index column =
          is_separate ? next_separate++
                      : std::lower_bound(shared.begin(), shared.end(), source) - shared.begin();
      joint.factor.block(static_cast<Eigen::Index>(i) * joint.dimension, column, joint.dimension,
                         1) =
          (is_separate ? bound : 1.0) *
          at_origin.col(static_cast<Eigen::Index>(k)).cwiseProduct(inverse_scale);
    }
  }
  return joint;
}

/// Takes the mean of the n blocks of m rows off each.
Eigen::MatrixXd deviations_of(const Eigen::MatrixXd& stacked, Eigen::Index count,
                              Eigen::Index dimension) {
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(dimension, stacked.cols());
  for (Eigen::Index i = 0; i < count; ++i) mean += stacked.middleRows(i * dimension, dimension);
  mean /= static_cast<double>(count);
  return stacked - mean.replicate(count, 1);
}

Eigen::Index rank_of(const Svd& decomposition, double tolerance) {
  const auto& values = decomposition.singularValues();
  return (values.array() > tolerance).count();
}

/// Orthonormal columns that span the range of each estimate's covariance.
std::vector<Eigen::MatrixXd> ranges_of(const JointEstimates& joint) {
  std::vector<Eigen::MatrixXd> ranges;
  for (Eigen::Index i = 0; i < joint.count; ++i) {
    const Svd decomposition = singular_values(joint.factor_of(i), Eigen::ComputeThinU);
    ranges.emplace_back(decomposition.matrixU().leftCols(rank_of(decomposition, rank_tolerance)));
  }
  return ranges;
}

/// Whether a direction of deviations lies within the smallest angle of what every estimate claims
/// to know exactly.
bool only_tilts_constraints(const Eigen::VectorXd& direction, Eigen::Index dimension,
                            const std::vector<Eigen::MatrixXd>& ranges) {
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const Eigen::VectorXd part =
        direction.segment(static_cast<Eigen::Index>(i) * dimension, dimension);
    if ((ranges[i].transpose() * part).norm() > nearest_constraints * part.norm() + rank_tolerance)
      return false;
  }
  return true;
}

std::string quantity(double value, const Component& component) {
  return fmt::format("{:.3g}{}", value, component.unit == "1" ? "" : " " + component.unit);
}

/// Two inputs that both claim to be exact and differ.
std::string exact_contradiction(std::span<const Output* const> inputs,
                                const JointEstimates& joint) {
  constexpr double rounding = 1e-12;
  const auto exact = [&](Eigen::Index i, Eigen::Index c) {
    return joint.factor_of(i).row(c).norm() <= rank_tolerance;
  };
  for (Eigen::Index c = 0; c < joint.dimension; ++c) {
    const Component& component =
        inputs.front()->estimate.type->components[static_cast<std::size_t>(c)];
    for (Eigen::Index i = 0; i < joint.count; ++i)
      for (Eigen::Index j = 0; exact(i, c) && j < i; ++j) {
        const double apart = (joint.offset(c, i) - joint.offset(c, j)) * joint.scale[c];
        const bool differs =
            std::abs(apart) > rounding * size_of(inputs, component.unit) +
                                  rank_tolerance * joint.scale[c] * largest_unexplained;
        if (differs && exact(j, c))
          return fmt::format("inputs {} and {} both claim an exact '{}', but differ by {}", j + 1,
                             i + 1, component.name, quantity(std::abs(apart), component));
      }
  }
  return {};
}

}  // namespace

std::vector<double> common_origin(std::span<const Output* const> inputs) {
  const PayloadDescriptor& type = *inputs.front()->estimate.type;
  if (is_flat(type)) return inputs.front()->estimate.value;
  std::vector<std::span<const double>> values;
  for (const Output* input : inputs) values.emplace_back(input->estimate.value);
  const std::vector<double> weights(values.size(), 1.0 / static_cast<double>(values.size()));
  return weighted_mean(type, values, weights);
}

JointEstimates joint_estimates(std::span<const Output* const> inputs,
                               std::span<const double> origin) {
  return lay_side_by_side(inputs, origin, false);
}

JointEstimates bounded_joint_estimates(std::span<const Output* const> inputs,
                                       std::span<const double> origin) {
  return lay_side_by_side(inputs, origin, true);
}

JointDeviations joint_deviations(const JointEstimates& joint) {
  const Eigen::Index n = joint.count;
  const Eigen::Index m = joint.dimension;
  JointDeviations result;
  result.value = deviations_of(joint.offset.reshaped(n * m, 1), n, m);
  if (joint.factor.cols() == 0) {
    result.directions.resize(n * m, 0);
    result.standard_deviations.resize(0);
    result.sources.resize(0, 0);
    return result;
  }
  const Svd decomposition =
      singular_values(deviations_of(joint.factor, n, m), Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Index rank = rank_of(decomposition, rank_tolerance);
  std::vector<Eigen::Index> kept;
  std::vector<Eigen::MatrixXd> ranges;
  // A direction that only tilts constraints cannot have a larger standard deviation than this.
  const double largest_tilt = nearest_constraints * std::sqrt(static_cast<double>(n * m));
  for (Eigen::Index k = 0; k < rank; ++k) {
    if (decomposition.singularValues()[k] <= largest_tilt) {
      if (ranges.empty()) ranges = ranges_of(joint);
      if (only_tilts_constraints(decomposition.matrixU().col(k), m, ranges)) continue;
    }
    kept.push_back(k);
  }
  result.directions = decomposition.matrixU()(Eigen::all, kept);
  result.standard_deviations = decomposition.singularValues()(kept);
  result.sources = decomposition.matrixV()(Eigen::all, kept);
  return result;
}

std::string contradiction(std::span<const Output* const> inputs, const JointEstimates& joint,
                          const JointDeviations& deviations) {
  if (std::string exact = exact_contradiction(inputs, joint); !exact.empty()) return exact;
  const Eigen::VectorXd unexplained = deviations.unexplained();
  Eigen::Index worst = 0;
  const double largest = unexplained.cwiseAbs().maxCoeff(&worst);
  if (!(largest > largest_unexplained)) return {};
  const Eigen::Index c = worst % joint.dimension;
  const Component& component =
      inputs.front()->estimate.type->components[static_cast<std::size_t>(c)];
  return fmt::format(
      "input {} is off the others' mean by {} in '{}', {:.3g} standard deviations, where the "
      "inputs' errors are shared or excluded and let them differ by nothing",
      worst / joint.dimension + 1, quantity(largest * joint.scale[c], component), component.name,
      largest);
}

Combination combine(std::span<const Output* const> inputs,
                    const std::function<Eigen::MatrixXd(const JointEstimates&)>& find_gains) {
  constexpr int most_steps = 20;
  constexpr double convergence_tolerance = 1e-10;  // in the scale's standard deviations
  const PayloadDescriptor& type = *inputs.front()->estimate.type;
  Combination result;
  result.value = common_origin(inputs);
  for (int step = 0; step < most_steps; ++step) {
    result.joint = joint_estimates(inputs, result.value);
    result.gains = find_gains(result.joint);
    const Eigen::VectorXd move = result.gains * result.joint.offset.reshaped();
    const Eigen::VectorXd si = move.cwiseProduct(result.joint.scale);
    retract(type, result.value, std::span(si.data(), type.dimension()), result.value);
    if (is_flat(type) || move.cwiseAbs().maxCoeff() <= convergence_tolerance) break;
  }
  transport_gains(type, result.joint.scale.asDiagonal() * result.joint.offset, result.gains);
  return result;
}

Eigen::MatrixXd gain_of(const Combination& combination, Eigen::Index i) {
  const JointEstimates& joint = combination.joint;
  return joint.scale.asDiagonal() *
         combination.gains.middleCols(i * joint.dimension, joint.dimension) *
         joint.scale.cwiseInverse().asDiagonal();
}

}  // namespace ilss
