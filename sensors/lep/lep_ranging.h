// Ranges from the LEP sensor's image positions, by its calibration.
#pragma once

#include <array>
#include <string>

#include "framework/module/module_type.h"
#include "sensors/lep/lep_geometry.h"
#include "sensors/lep/lep_scan.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// Turns a scan of image positions into a scan of ranges (Pears 1997, eq. 6), reading by reading in
/// inverse range, to which an image position is nearly proportional. The sd of each inverse range
/// follows from the image position's, which follows from the detector current, and not from the
/// noisy range. The calibration's error is the same in every reading: `error_1` to `error_5` are
/// the relative errors of f and d, the error of gamma (rad), the relative error of s and that of
/// the projected vergence (rad), which turns the rays as well.
/// Output frame: the input's: the head's axis, x to the right and z forward at the time of the
/// scan's last reading, head angle 0; angles from x towards z (Pears 1997, sec. 4). Scan angles, as
/// in his section 3, run from z towards x.
/// Image positions that no range belongs to are left out. Faults: out_of_range where that leaves no
/// reading, or the calibration is no geometry.
class LepRanging final : public Module {
 public:
  static constexpr std::string_view name = "lep_ranging";
  static constexpr std::string_view description =
      "ranges from a LEP sensor's image positions, with the calibration's errors carried apart";
  static constexpr std::string_view reference = "Pears 1997, eq. 6 to 9";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::out_of_range};

  template <typename T>
  struct Parameters {
    T focal_length, baseline, vergence, lens_distance, origin_x, origin_z, projected_vergence;
    static constexpr std::string_view name = "lep_ranging_parameters";
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
         Geometry::circular}};
  };

  static Interface interface();

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
};

}  // namespace ilss
