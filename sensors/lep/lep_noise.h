// The noise current of a LEP's detector, from the scatter of image positions at known currents.
#pragma once

#include <span>

#include "framework/module/outcome.h"

namespace ilss {

/// The sd of image positions (m) that was measured at one detector current I_0 (A).
struct LepNoiseReading {
  double current = 0;
  double deviation = 0;
};

/// log(sd of p) against log(I_0), by least squares.
struct LepNoiseFit {
  double noise_current = 0;            ///< I_n (A), the slope being -1 as equation 2 says
  double noise_current_deviation = 0;  ///< its standard error, from the residuals (A)
  double residual = 0;                 ///< sd of log(sd of p) about that line
  double slope = 0;                    ///< where it is free
  double slope_deviation = 0;
  std::size_t readings = 0;
};

/// The regression of Pears 1997, section 2.1: log(sd of p) = log(I_n P / 2) - log(I_0), for a
/// detector of length P (m). Faults: bad_data for a current or sd that is not positive and finite;
/// degenerate for fewer than three readings, or currents that are all the same.
Outcome<LepNoiseFit> fit_noise_current(std::span<const LepNoiseReading> readings,
                                       double detector_length);

}  // namespace ilss
