#include "sensors/laser/acquire/laser_correction.h"

#include <Eigen/Core>
#include <cmath>

namespace ilss {

double range_bias(std::span<const double> coefficients, double share) {
  double sum = 0;
  for (std::size_t k = coefficients.size(); k-- > 0;) sum = sum * share + coefficients[k];
  return sum;
}

Interface LaserCorrection::interface() {
  return {.inputs = {{"scan", &descriptor<LaserScan>()}},
          .output = &descriptor<LaserScan>(),
          .frame_of_input = 0};
}

Outcome<> LaserCorrection::evaluate(const Evaluation& evaluation, Output& output) {
  const Estimate& scan = evaluation.input(0);
  const std::vector<double>& parameters = evaluation.parameters.value;
  const double at = parameters[range_biases];
  if (!(at > 0)) return Fault{FaultKind::out_of_range, "bias_range must be above 0"};
  const std::span<const double> coefficients(parameters.data(), range_biases);
  const std::span<const LaserBeam> beams = beams_of(*evaluation.inputs[0]);
  const std::span<LaserBeam> corrected = make_beams(output, beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const double range = beams[i].range;
    const double less = range == 0 ? 0 : range_bias(coefficients, range / at);
    corrected[i] = {beams[i].bearing, std::max(0.0, range - less)};
  }
  output.estimate.value = scan.value;
  output.estimate.value[bias_range] = at;
  // What the calibration says too much is taken off too much; what the scan knew already is told
  // by the new reference.
  constexpr auto rows = static_cast<Eigen::Index>(dimension_of<LaserScan>);
  constexpr auto columns = static_cast<Eigen::Index>(dimension_of<Parameters>);
  Eigen::Matrix<double, rows, columns> by_parameters = Eigen::Matrix<double, rows, columns>::Zero();
  Eigen::Matrix<double, rows, rows> by_scan = Eigen::Matrix<double, rows, rows>::Identity();
  double scale = 1;
  for (std::size_t k = 0; k < range_biases; ++k, scale *= at / scan.value[bias_range]) {
    const auto row = static_cast<Eigen::Index>(first_bias + k);
    by_parameters(row, static_cast<Eigen::Index>(k)) = -1;
    by_scan(row, row) = scale;
  }
  const std::array<LineageTerm, 2> terms{
      {{by_scan.data(), &scan.lineage}, {by_parameters.data(), &evaluation.parameters.lineage}}};
  compose(terms, dimension_of<LaserScan>, output.estimate.lineage);
  return {};
}

}  // namespace ilss
