// The LEP range sensor on its turning head, simulated in a scene.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/lep/head_motion.h"
#include "sensors/lep/lep_beam.h"
#include "sensors/lep/lep_scan.h"
#include "sensors/scene/scene.h"

namespace ilss {

/// Sensor: image positions along the scan of a lateral-effect photodiode range sensor (Pears 1997,
/// sec. 2 and 3.3), with the noise that follows from the detector current, sd = (P/2) I_n / I_0
/// (eq. 2). The scans sweep from left to right again and again, 2,500 readings a second; a tick
/// gives the last `readings` of them, the last one taken at the tick's time. The parameters are the
/// truth of the simulated world, so their uncertainty does not pass into the readings: what is not
/// known of the sensor belongs to `lep_ranging`.
/// Readings are left out where nothing comes back (also: where the scene hides the spot from the
/// lens), where the current exceeds the saturation current, and where the image falls beside the
/// photodiode.
/// With a `bandwidth` the detector is a low pass: noise of neighbouring readings is correlated, and
/// their images are smeared, but for a constant delay that the scan angles allow for.
/// Faults: no_detection where no reading of a tick has an image; out_of_range where the parameters
/// are no sensor's.
/// Commands: `rotate_to` an angle and `rotate_at` a rate, refused beyond the head's stops and the
/// drive's fastest rate.
class LepSensor final : public Module {
 public:
  static constexpr std::string_view name = "lep_sensor";
  static constexpr std::string_view description =
      "image positions of a LEP range sensor on a turning head, simulated in a scene";
  static constexpr std::string_view reference = "Pears 1997, sec. 2 and 3.3";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::no_detection, FaultKind::out_of_range};
  static std::vector<CommandDeclaration> commands();

  template <typename T>
  struct Parameters {
    T focal_length, baseline, vergence, lens_distance, origin_x, origin_z, projected_vergence,
        detector_length, noise_current, robot_x, robot_z, robot_heading;
    static constexpr std::string_view name = "lep_sensor_parameters";
    static constexpr auto fields = Fields{
        {"focal_length", "m", "f of the collecting lens", LepGeometry<double>{}.focal_length},
        {"baseline", "m", "d, from the laser's to the lens's centre of turning",
         LepGeometry<double>{}.baseline},
        {"vergence", "rad", "gamma, of the lens towards the laser", LepGeometry<double>{}.vergence,
         Geometry::circular},
        {"lens_distance", "m", "s, of the lens behind its centre of turning",
         LepGeometry<double>{}.lens_distance},
        {"origin.x", "m", "the scan's origin, to the right of the head's axis", 0},
        {"origin.z", "m", "the scan's origin, forward of the head's axis", 0},
        {"projected_vergence", "rad", "what the laser's angle is more than the scan angle", 0,
         Geometry::circular},
        {"detector_length", "m", "P of the photodiode", 0.01},
        {"noise_current", "A", "I_n of the photodiode and its amplifier", 36.2e-12},
        {"robot.x", "m", "where the head's axis starts in the scene", 0},
        {"robot.z", "m", "where the head's axis starts in the scene", 0},
        {"robot.heading", "rad", "where the vehicle looks at first, to the right", 0,
         Geometry::circular}};
  };

  struct Options {
    FileOf<Scene> scene;
    std::int64_t readings = 256;
    std::int64_t scan_readings = 256;
    double field_of_view = 0.69813170079773179;  ///< 40 degrees
    double reading_rate = 2500;                  ///< 1/s
    LepBeam beam;
    std::optional<double> bandwidth;
    double saturation_current = 400e-9;
    double head_angle = 0;
    HeadDrive drive;
    double speed = 0;
    double turn_rate = 0;
    std::string frame = "lep";
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit LepSensor(const Options& options);

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// A scan without noise at the start of the run, with the noise it would have.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;
  Outcome<> command(const Command& command) override;
  void reset() override;

  /// Where the vehicle is at a time: world axes, heading to the right.
  ScenePose vehicle(const Parameters<double>& parameters, double time) const;
  const Scene& scene() const { return options_.scene.content; }

 private:
  /// The currents behind one reading: their sum and the sum of each times its image position.
  struct Signal {
    double current = 0;
    double moment = 0;
  };
  template <typename DrawNoise>
  Outcome<> scan(const Evaluation& evaluation, std::int64_t last, double end, DrawNoise draw_noise,
                 Output& output);
  std::int64_t place_in_scan(std::int64_t reading) const;

  Options options_;
  HeadMotion head_;
  double correlation_ = 0;       ///< of one reading's noise and the next one's
  std::int64_t remembered_ = 0;  ///< readings that the low pass holds anything of
};

}  // namespace ilss
