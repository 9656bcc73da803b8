#include "sensors/lep/lep_detector.h"

#include <fmt/format.h>

#include <cmath>

namespace ilss {
namespace {

constexpr std::size_t of_length = 0;
constexpr std::size_t of_noise = 1;

/// What equation 2 says of a reading, the noise current being uncertain itself.
double deviation(const Estimate& parameters, double current) {
  const double noise =
      std::hypot(parameters.value[of_noise], parameters.lineage.standard_deviation(of_noise));
  return image_position_deviation(parameters.value[of_length], noise, current);
}

Outcome<> check(const Estimate& parameters, double current) {
  if (!(parameters.value[of_length] > 0) || !(parameters.value[of_noise] >= 0))
    return Fault{FaultKind::out_of_range,
                 fmt::format("a detector of length {:g} m and noise current {:g} A cannot be",
                             parameters.value[of_length], parameters.value[of_noise])};
  if (!(current > 0))
    return Fault{FaultKind::out_of_range,
                 fmt::format("no light: the detector current is {:g} A", current)};
  return {};
}

}  // namespace

Interface LepDetector::interface() {
  return {{{"currents", &descriptor<DetectorCurrents>(), {}, false}},
          &descriptor<ImagePosition>(),
          {},
          0};
}

Outcome<> LepDetector::evaluate(const Evaluation& evaluation, Output& output) {
  const Estimate& parameters = evaluation.parameters;
  const Estimate& currents = evaluation.input(0);
  const auto [i1, i2] = payload_of<DetectorCurrents>(currents);
  const double total = i1 + i2;
  if (Outcome<> outcome = check(parameters, total); !outcome) return outcome;
  if (i1 < 0 || i2 < 0)
    return Fault{FaultKind::out_of_range,
                 fmt::format("currents of {:g} A and {:g} A put the image beyond the detector's "
                             "ends",
                             i1, i2)};
  const double half = parameters.value[of_length] / 2;
  const double share = (i1 - i2) / total;
  output.estimate.value.assign({half * share, total});
  const std::array<double, 4> by_parameters = {share / 2, 0, 0, 0};
  const double by_share = 2 * half / (total * total);
  const std::array<double, 4> by_currents = {by_share * i2, 1, -by_share * i1, 1};
  const std::array<LineageTerm, 2> terms = {
      {{by_parameters.data(), &parameters.lineage}, {by_currents.data(), &currents.lineage}}};
  compose(terms, 2, output.estimate.lineage);
  output.estimate.lineage.add(evaluation.fresh(0), 0, deviation(parameters, total));
  return {};
}

Outcome<> LepDetector::expect(const Evaluation& evaluation, const Output* operating_point,
                              Output& output) {
  if (operating_point == nullptr) return evaluate(evaluation, output);
  const auto [position, current] = payload_of<ImagePosition>(operating_point->estimate);
  if (std::isnan(current))
    return Fault{FaultKind::no_error_known,
                 "the error of an image position follows from its current; give that, too"};
  if (Outcome<> outcome = check(evaluation.parameters, current); !outcome) return outcome;
  output.estimate.value.assign({position, current});
  output.estimate.lineage.reset(2);
  output.estimate.lineage.add(evaluation.fresh(0), 0, deviation(evaluation.parameters, current));
  return {};
}

}  // namespace ilss
