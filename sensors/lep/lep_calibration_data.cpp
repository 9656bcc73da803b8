#include "sensors/lep/lep_calibration_data.h"

#include "framework/estimate/random.h"

namespace ilss {
namespace {

/// Number i of `count` equal steps from `first` to `last`.
double step(double first, double last, std::size_t i, std::size_t count) {
  return first + (last - first) * static_cast<double>(i) / static_cast<double>(count - 1);
}

}  // namespace

std::vector<LepCalibrationPoint> simulate_lep_calibration(const LepCalibrationDesign& design,
                                                          std::uint64_t seed) {
  RandomBits random(derive_seed(seed, "lep calibration"));
  std::vector<LepCalibrationPoint> points;
  points.reserve(design.angles * design.depths);
  for (std::size_t a = 0; a < design.angles; ++a) {
    for (std::size_t d = 0; d < design.depths; ++d) {
      const double angle = step(-design.half_field, design.half_field, a, design.angles);
      const double distance = step(design.nearest, design.farthest, d, design.depths);
      const double depth = design.origin.z + distance;
      const double deviation = image_position_deviation(
          design.detector_length, design.noise_current, design.current(distance));
      const double exact = model_image_position(design.geometry, design.origin, angle, depth);
      points.push_back({angle, depth, exact + deviation * draw_normal(random), deviation});
    }
  }
  return points;
}

}  // namespace ilss
