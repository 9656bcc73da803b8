// The systematic error of a laser's ranges, taken off.
#pragma once

#include <array>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/laser/laser_scan.h"

namespace ilss {

/// Estimator: corrects a laser_scan by a calibrated polynomial (Núñez et al. 2009, sec. 4.4): a
/// range r becomes
///   r - sum of bias_k (r / bias_range)^k.
/// `ilss calibrate laser` makes the coefficients and their covariance, which go on with the scan as
/// what all its ranges have in common: they do not average out. Beyond the ranges that were
/// calibrated the polynomial runs away, and its stated error with it.
/// Input: a laser_scan; output: one in its frame. Faults: out_of_range where bias_range is not
/// above 0.
class LaserCorrection final : public Module {
 public:
  static constexpr std::string_view name = "laser_correction";
  static constexpr std::string_view description =
      "takes the systematic error off a laser's ranges: a calibrated polynomial";
  static constexpr std::string_view reference = "Núñez et al. 2009, sec. 4.4";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::out_of_range};

  template <typename T>
  struct Parameters {
    T bias_0, bias_1, bias_2, bias_3, bias_4, bias_5, bias_6, bias_range;
    static constexpr std::string_view name = "laser_correction_parameters";
    static constexpr auto fields =
        Fields{{"bias_0", "m", "of all ranges: an offset", 0},
               {"bias_1", "m", "by the range: a scale", 0},
               {"bias_2", "m", "by its square", 0},
               {"bias_3", "m", "and so on", 0},
               {"bias_4", "m", "", 0},
               {"bias_5", "m", "", 0},
               {"bias_6", "m", "", 0},
               {"bias_range", "m", "at which each bias is what it says; exact", 1}};
  };

  static Interface interface();

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
};

/// The systematic error of a range by its coefficients (m).
double range_bias(std::span<const double> coefficients, double share);

}  // namespace ilss
