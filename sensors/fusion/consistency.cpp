#include "sensors/fusion/consistency.h"

#include <boost/math/special_functions/gamma.hpp>

#include "sensors/fusion/fuse.h"
#include "sensors/fusion/fusion_inputs.h"
#include "sensors/fusion/joint_deviations.h"

namespace ilss {

Interface ConsistencyModule::interface() {
  Interface interface = fusion_interface();
  interface.output = &descriptor<Consistency>();
  interface.frame_of_input.reset();  // its numbers have no place in space
  return interface;
}

void ConsistencyModule::resolve(const Connections& connections, Settings&, Interface& interface) {
  resolve_fusion(connections, 2, name, interface);
}

Outcome<> ConsistencyModule::evaluate(const Evaluation& evaluation, Output& output) {
  const std::vector<double> origin = common_origin(evaluation.inputs);
  const JointEstimates joint = inputs_of_unknown_correlation(evaluation)
                                   ? bounded_joint_estimates(evaluation.inputs, origin)
                                   : joint_estimates(evaluation.inputs, origin);
  const JointDeviations deviations = joint_deviations(joint);
  const Eigen::VectorXd normalized = (deviations.directions.transpose() * deviations.value)
                                         .cwiseQuotient(deviations.standard_deviations);
  Consistency<double> result{normalized.squaredNorm(), static_cast<double>(normalized.size()), 1};
  if (!contradiction(evaluation.inputs, joint, deviations).empty())
    result.probability = 0;
  else if (normalized.size() > 0)
    result.probability = boost::math::gamma_q(result.degrees_of_freedom / 2, result.nis / 2);
  assign(output.estimate, result);
  return {};
}

}  // namespace ilss
