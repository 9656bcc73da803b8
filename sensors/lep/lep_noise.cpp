#include "sensors/lep/lep_noise.h"

#include <fmt/format.h>

#include <cmath>

namespace ilss {

Outcome<LepNoiseFit> fit_noise_current(std::span<const LepNoiseReading> readings,
                                       double detector_length) {
  if (readings.size() < 3)
    return Fault{FaultKind::degenerate,
                 fmt::format("a noise current needs 3 readings or more, got {}", readings.size())};
  const auto n = static_cast<double>(readings.size());
  double mean_current = 0;  // of the logarithms, as all that follows
  double mean_deviation = 0;
  for (const LepNoiseReading& reading : readings) {
    if (!(reading.current > 0 && reading.deviation > 0) || std::isinf(reading.current) ||
        std::isinf(reading.deviation))
      return Fault{FaultKind::bad_data,
                   fmt::format("a current of {:g} A with an sd of {:g} m: both must be positive",
                               reading.current, reading.deviation)};
    mean_current += std::log(reading.current) / n;
    mean_deviation += std::log(reading.deviation) / n;
  }
  const double intercept = mean_deviation + mean_current;  // of the line of slope -1
  double fixed_squares = 0;
  double spread = 0;
  double product = 0;
  double deviation_spread = 0;
  for (const LepNoiseReading& reading : readings) {
    const double x = std::log(reading.current) - mean_current;
    const double y = std::log(reading.deviation) - mean_deviation;
    fixed_squares += (y + x) * (y + x);
    spread += x * x;
    product += x * y;
    deviation_spread += y * y;
  }
  constexpr double rounding = 1e-12;
  if (!(spread > rounding))
    return Fault{FaultKind::degenerate,
                 "the detector currents are all the same: a noise current "
                 "needs several to be told from other noise"};
  LepNoiseFit fit;
  fit.readings = readings.size();
  fit.residual = std::sqrt(fixed_squares / (n - 1));
  fit.noise_current = std::exp(intercept) / (detector_length / 2);
  fit.noise_current_deviation = fit.noise_current * fit.residual / std::sqrt(n);
  fit.slope = product / spread;
  const double free_squares = std::fmax(0, deviation_spread - fit.slope * product);
  fit.slope_deviation = std::sqrt(free_squares / (n - 2) / spread);
  return fit;
}

}  // namespace ilss
