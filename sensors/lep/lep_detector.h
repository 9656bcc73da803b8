// The LEP's photodiode: where the image falls on it, from the currents of its two terminals.
#pragma once

#include <array>

#include "framework/module/module_type.h"

namespace ilss {

/// The photocurrents at the two ends of a lateral-effect photodiode.
template <typename T>
struct DetectorCurrents {
  T current_1, current_2;
  static constexpr std::string_view name = "detector_currents";
  static constexpr std::string_view documentation =
      "terminal currents of a lateral-effect "
      "photodiode";
  static constexpr auto fields =
      Fields{{"current_1", "A", "at the end where positions are above 0"},
             {"current_2", "A", "at the other end"}};
};

/// Where the centre of the light falls on the detector.
template <typename T>
struct ImagePosition {
  T position, current;
  static constexpr std::string_view name = "image_position";
  static constexpr std::string_view documentation = "where light falls on a position detector";
  static constexpr auto fields = Fields{{"position", "m", "from the detector's middle"},
                                        {"current", "A", "the detector current I_0", 0}};
};

/// The shipped sensor's detector: P of Pears 1997, and the noise current that `ilss calibrate
/// lep_noise` finds in its Table 2.
inline constexpr double lep_detector_length = 0.01;    // m
inline constexpr double lep_noise_current = 36.2e-12;  // A

/// The sd of an image position (m): (P/2) I_n / I_0 (Pears 1997, equation 2).
constexpr double image_position_deviation(double detector_length, double noise_current,
                                          double current) {
  return detector_length / 2 * noise_current / current;
}

/// Estimator: image position p = (P/2) (I_1 - I_2) / (I_1 + I_2) (Pears 1997, equation 1), with a
/// fresh error a tick of sd (P/2) sqrt(I_n² + u(I_n)²) / I_0 (equation 2), u(I_n) being the stated
/// sd of the noise current. Errors of the currents and of the length pass into the output.
/// Faults: out_of_range without a positive total current, for an image beyond the detector's ends
/// (a current below 0) or a detector length or noise current that cannot be; no_error_known when
/// asked for the error at a position without a current.
class LepDetector final : public Module {
 public:
  static constexpr std::string_view name = "lep_detector";
  static constexpr std::string_view description =
      "image position from the two currents of a lateral-effect photodiode";
  static constexpr std::string_view reference = "Pears 1997, equations 1 and 2";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::out_of_range, FaultKind::no_error_known};

  template <typename T>
  struct Parameters {
    T detector_length, noise_current;
    static constexpr std::string_view name = "lep_detector_parameters";
    static constexpr auto fields =
        Fields{{"detector_length", "m", "P, from end to end", lep_detector_length},
               {"noise_current", "A", "I_n, in the detector's bandwidth", lep_noise_current}};
  };

  static Interface interface();

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// At an operating point that has a detector current: the error that goes with it.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;
};

}  // namespace ilss
