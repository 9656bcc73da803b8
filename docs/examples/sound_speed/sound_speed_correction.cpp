// A module of one's own: corrects a sonar's range for the temperature of the air. This file is all
// there is to it: a formula, its declarations, and the function that registers it.
#include <array>
#include <cmath>

#include "framework/module/function_module.h"
#include "framework/module/registry.h"
#include "sensors/sonar/sonar_reading.h"

namespace {

using ilss::Fault;
using ilss::FaultKind;
using ilss::Outcome;
using ilss::SonarReading;

/// Function module: r' = r sqrt(T / T0). A sonar times an echo and multiplies by the speed of sound
/// that its maker assumed, at T0; in air of temperature T sound travels at c = sqrt(gamma R T / M)
/// (ideal gas), so only the ratio of the temperatures matters. 10 K are worth 1.7 % of the range.
class SoundSpeedCorrection {
 public:
  // What users see: `ilss modules sound_speed_correction`.
  static constexpr std::string_view name = "sound_speed_correction";
  static constexpr std::string_view description = "sonar range corrected for air temperature";
  static constexpr std::string_view reference = "speed of sound in an ideal gas";
  static constexpr std::array<std::string_view, 1> inputs = {"reading"};
  static constexpr std::array faults = {FaultKind::out_of_range};

  // Each parameter may carry an uncertainty in YAML; an uncertain temperature is a source of error
  // that stays the same from tick to tick, and the budget names it.
  template <typename T>
  struct Parameters {
    T air_temperature, assumed_temperature;
    static constexpr std::string_view name = "sound_speed_correction_parameters";
    static constexpr auto fields =
        ilss::Fields{{"air_temperature", "K", "of the air between sonar and wall"},
                     {"assumed_temperature", "K", "for which the sonar computes ranges", 293.15}};
  };

  // Generic in the scalar, so that ilss can differentiate it: the errors of range and temperature
  // propagate without a line about errors here.
  template <typename T>
  Outcome<SonarReading<T>> operator()(const Parameters<T>& parameters,
                                      const SonarReading<T>& reading) const {
    using std::sqrt;
    if (!(parameters.air_temperature > T(0)) || !(parameters.assumed_temperature > T(0)))
      return Fault{FaultKind::out_of_range, "a temperature is not above absolute zero"};
    SonarReading<T> corrected = reading;
    corrected.range =
        reading.range * sqrt(parameters.air_temperature / parameters.assumed_temperature);
    return corrected;
  }
};

}  // namespace

/// Called by `ilss --plugin` once the library is loaded.
extern "C" void ilss_register(ilss::Registry& registry) { registry.add<SoundSpeedCorrection>(); }
