#include "sensors/fusion/fuse.h"

#include <algorithm>
#include <cmath>

#include "sensors/fusion/covariance_intersection.h"
#include "sensors/fusion/fusion_inputs.h"
#include "sensors/fusion/joint_deviations.h"

namespace ilss {
namespace {

/// The W_i side by side, in units of the scale.
Eigen::MatrixXd best_gains(const JointEstimates& joint, const JointDeviations& deviations) {
  const Eigen::Index m = joint.dimension;
  const double share = 1.0 / static_cast<double>(joint.count);
  Eigen::MatrixXd mean_factor = Eigen::MatrixXd::Zero(m, joint.factor.cols());
  for (Eigen::Index i = 0; i < joint.count; ++i) mean_factor += share * joint.factor_of(i);
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(m, m);
  Eigen::MatrixXd gains = share * identity.replicate(1, joint.count);
  if (deviations.standard_deviations.size() > 0)
    gains -= mean_factor * deviations.sources *
             deviations.standard_deviations.cwiseInverse().asDiagonal() *
             deviations.directions.transpose();
  // Together they are the identity, as the combination of the values takes for granted.
  gains.leftCols(m) = identity;
  for (Eigen::Index i = 1; i < joint.count; ++i) gains.leftCols(m) -= gains.middleCols(i * m, m);
  // So that what is exact comes out exact.
  constexpr double rounding = 1e-13;
  return gains.unaryExpr([](double gain) {
    const double whole = std::round(gain);
    return std::abs(gain - whole) <= rounding ? whole : gain;
  });
}

}  // namespace

bool inputs_of_unknown_correlation(const Evaluation& evaluation) {
  return evaluation.correlation_unknown ||
         std::any_of(evaluation.inputs.begin(), evaluation.inputs.end(),
                     [](const Output* input) { return input->estimate.correlation_unknown; });
}

Interface Fuse::interface() { return fusion_interface(); }

void Fuse::resolve(const Connections& connections, Settings&, Interface& interface) {
  resolve_fusion(connections, 2, name, interface);
}

Outcome<> Fuse::evaluate(const Evaluation& evaluation, Output& output) {
  if (inputs_of_unknown_correlation(evaluation))
    return intersect_covariances(evaluation, output.estimate);
  const auto inputs = evaluation.inputs;
  JointDeviations deviations;
  Combination best = combine(inputs, [&](const JointEstimates& joint) {
    deviations = joint_deviations(joint);
    return best_gains(joint, deviations);
  });
  if (std::string reason = contradiction(inputs, best.joint, deviations); !reason.empty())
    return Fault{FaultKind::degenerate, std::move(reason)};
  output.estimate.value = std::move(best.value);
  output.estimate.labels = inputs.front()->estimate.labels;
  std::vector<Eigen::MatrixXd> jacobians;
  std::vector<LineageTerm> terms;
  for (Eigen::Index i = 0; i < best.joint.count; ++i) jacobians.push_back(gain_of(best, i));
  for (std::size_t i = 0; i < inputs.size(); ++i)
    terms.push_back({jacobians[i].data(), &inputs[i]->estimate.lineage});
  compose(terms, inputs.front()->estimate.dimension(), output.estimate.lineage);
  return {};
}

}  // namespace ilss
