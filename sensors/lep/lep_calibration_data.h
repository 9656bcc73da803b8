// Simulated calibrations of the LEP sensor, whose truth is known.
#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include "sensors/lep/lep_calibration.h"
#include "sensors/lep/lep_detector.h"

namespace ilss {

/// How a simulated sensor is calibrated. The target is flat, across the z axis, and moved from
/// `nearest` to `farthest` in equal steps.
struct LepCalibrationDesign {
  std::size_t angles = 256;
  std::size_t depths = 40;
  double half_field = 20 * std::numbers::pi / 180;  ///< scan angles reach from - to + this (rad)
  double nearest = 0.4;                             ///< from the scan origin, along z (m)
  double farthest = 2.5;
  LepGeometry<double> geometry = {};
  LepScanOrigin origin = {};
  double detector_length = lep_detector_length;  ///< m
  double noise_current = lep_noise_current;      ///< A
  /// I_0 z² of the paper's calibration target (A m²): the mean of its Table 2.
  double current_by_depth = 25.8e-9;

  /// The detector current (A) from a target so far from the scan origin (m).
  double current(double distance) const { return current_by_depth / (distance * distance); }
};

/// One noisy reading at each scan angle and depth, depths of one angle together.
std::vector<LepCalibrationPoint> simulate_lep_calibration(const LepCalibrationDesign& design,
                                                          std::uint64_t seed);

}  // namespace ilss
