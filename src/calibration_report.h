// What `ilss calibrate` says and writes.
#pragma once

#include <string>

#include "framework/report/estimate_json.h"
#include "sensors/lep/lep_calibration.h"
#include "sensors/lep/lep_noise.h"
#include "sensors/lep/lep_scan_origin.h"
#include "sensors/lep/lep_table.h"

namespace ilss {

/// How the calibration's look-up table does; `fault` where the points make no table.
struct LepTableReport {
  LepTableError interpolation;
  LepTableError with_noise;
  std::string fault;
};

/// All that came of `ilss calibrate lep`.
struct LepCalibrationReport {
  std::string file;
  LepCalibration calibration;
  std::optional<LepScanOriginFit> origin;  ///< where it was fitted
  LepTableReport table;
  int largest_line = 0;        ///< of the residual that is largest
  int largest_in_sd_line = 0;  ///< of the one that is largest by its sd
};

std::string calibration_text(const LepCalibrationReport& report);
Json calibration_json(const LepCalibrationReport& report);
/// A vector constant with its covariance, as a graph's `constants: {lep: {file: ...}}` takes it.
std::string calibration_yaml(const LepCalibrationReport& report);

/// All that came of `ilss calibrate lep_noise`.
struct LepNoiseReport {
  std::string file;
  double detector_length = 0;  ///< m
  LepNoiseFit fit;
};

std::string noise_text(const LepNoiseReport& report);
Json noise_json(const LepNoiseReport& report);
/// A scalar constant with its std.
std::string noise_yaml(const LepNoiseReport& report);

}  // namespace ilss
