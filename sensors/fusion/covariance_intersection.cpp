#include "sensors/fusion/covariance_intersection.h"

#include "framework/estimate/decompositions.h"
#include "sensors/fusion/fusion_inputs.h"

namespace ilss {
namespace {

/// What covariance intersection works with, in units of the joint estimates' scale.
struct Intersection {
  Eigen::VectorXd weights;                   ///< w_i
  std::vector<Eigen::MatrixXd> information;  ///< P_i⁻¹
  Eigen::MatrixXd covariance;                ///< P
};

/// The weights of the largest det(sum w_i P_i⁻¹) by w_i <- w_i tr(P P_i⁻¹) / m, which never leaves
/// the simplex and never lowers the determinant (the multiplicative rule of D-optimal design,
/// Silvey, Titterington & Torsney 1978); at the optimum no trace is above m.
Intersection intersection_of(const JointEstimates& joint) {
  constexpr double exact_variance = 1e-12;
  constexpr int most_steps = 300;
  constexpr double convergence_tolerance = 1e-6;
  const Eigen::Index m = joint.dimension;
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(m, m);
  Intersection result;
  result.weights.setConstant(joint.count, 1.0 / static_cast<double>(joint.count));
  for (Eigen::Index i = 0; i < joint.count; ++i) {
    const Eigen::MatrixXd covariance =
        joint.factor_of(i) * joint.factor_of(i).transpose() + exact_variance * identity;
    result.information.push_back(inverse_of_positive(covariance));
  }
  Eigen::VectorXd traces(joint.count);
  for (int step = 0; step < most_steps; ++step) {
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
    for (Eigen::Index i = 0; i < joint.count; ++i)
      information += result.weights[i] * result.information[static_cast<std::size_t>(i)];
    result.covariance = inverse_of_positive(information);
    for (Eigen::Index i = 0; i < joint.count; ++i)
      traces[i] =
          result.covariance.cwiseProduct(result.information[static_cast<std::size_t>(i)]).sum() /
          static_cast<double>(m);
    if (traces.maxCoeff() <= 1 + convergence_tolerance) break;
    result.weights = result.weights.cwiseProduct(traces);
    result.weights /= result.weights.sum();
  }
  return result;
}

/// The W_i side by side.
Eigen::MatrixXd gains_of(const Intersection& intersection) {
  const Eigen::Index m = intersection.covariance.rows();
  const Eigen::Index count = intersection.weights.size();
  Eigen::MatrixXd gains(m, m * count);
  Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(m, m);
  for (Eigen::Index i = 0; i < count; ++i) {
    gains.middleCols(i * m, m) = intersection.weights[i] * intersection.covariance *
                                 intersection.information[static_cast<std::size_t>(i)];
    rest -= gains.middleCols(i * m, m);
  }
  // Rounding: the gains add up to the identity. What makes up for it goes where it costs least.
  Eigen::Index heaviest = 0;
  intersection.weights.maxCoeff(&heaviest);
  gains.middleCols(heaviest * m, m) += rest;
  return gains;
}

Eigen::MatrixXd random_covariance(const Lineage& lineage, const Eigen::VectorXd& scale) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(scale.size(), scale.size());
  for (std::size_t k = 0; k < lineage.size(); ++k) {
    if (lineage.sources()[k].persistent()) continue;
    const Eigen::VectorXd column =
        lineage.factor().col(static_cast<Eigen::Index>(k)).cwiseQuotient(scale);
    sum += column * column.transpose();
  }
  return sum;
}

void add_persistent(const Lineage& lineage, const Eigen::MatrixXd& gain, Lineage& out) {
  for (std::size_t k = 0; k < lineage.size(); ++k) {
    if (!lineage.sources()[k].persistent()) continue;
    const Eigen::VectorXd column = gain * lineage.factor().col(static_cast<Eigen::Index>(k));
    out.add(lineage.sources()[k],
            std::span<const double>(column.data(), static_cast<std::size_t>(column.size())));
  }
}

}  // namespace

Outcome<> intersect_covariances(const Evaluation& evaluation, Estimate& estimate) {
  const auto inputs = evaluation.inputs;
  const JointEstimates bounded = bounded_joint_estimates(inputs, common_origin(inputs));
  if (std::string reason = contradiction(inputs, bounded, joint_deviations(bounded));
      !reason.empty())
    return Fault{FaultKind::degenerate, std::move(reason)};
  Intersection intersection;
  Combination combination = combine(inputs, [&](const JointEstimates& joint) {
    intersection = intersection_of(joint);
    return gains_of(intersection);
  });
  const JointEstimates& joint = combination.joint;
  const Eigen::Index m = joint.dimension;
  Eigen::MatrixXd bound = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index i = 0; i < joint.count; ++i) {
    if (intersection.weights[i] <= 0) continue;  // its gain is 0
    const auto gain = combination.gains.middleCols(i * m, m);
    bound += gain *
             random_covariance(inputs[static_cast<std::size_t>(i)]->estimate.lineage, joint.scale) *
             gain.transpose() / intersection.weights[i];
  }
  estimate.value = std::move(combination.value);
  estimate.labels = inputs.front()->estimate.labels;
  estimate.lineage.reset(static_cast<std::size_t>(m));
  for (Eigen::Index i = 0; i < joint.count; ++i)
    add_persistent(inputs[static_cast<std::size_t>(i)]->estimate.lineage, gain_of(combination, i),
                   estimate.lineage);
  const Eigen::MatrixXd random = joint.scale.asDiagonal() * bound * joint.scale.asDiagonal();
  estimate.lineage.add_noise(evaluation.fresh(0), (random + random.transpose()) / 2);
  estimate.correlation_unknown = true;
  return {};
}

Interface CovarianceIntersection::interface() { return fusion_interface(); }

void CovarianceIntersection::resolve(const Connections& connections, Settings&,
                                     Interface& interface) {
  resolve_fusion(connections, 2, name, interface);
}

Outcome<> CovarianceIntersection::evaluate(const Evaluation& evaluation, Output& output) {
  return intersect_covariances(evaluation, output.estimate);
}

}  // namespace ilss
