// The LEP sensor's calibration table, and depths from it by interpolation.
#pragma once

#include <span>
#include <vector>

#include "sensors/lep/lep_calibration.h"

namespace ilss {

/// What the table says of a reading.
struct LepTableDepth {
  double depth = 0;  ///< z in the sensor frame (m)
  double gain = 0;   ///< dz/dp, which scales the image position's sd (Pears 1997, section 2.1)
};

/// Image positions at every combination of some scan angles and target depths, as the real sensor
/// keeps them in place of a model: z is interpolated linearly in image position at the two
/// neighbouring scan angles, then linearly in scan angle.
class LepTable {
 public:
  /// The table of a calibration's points. Faults: bad_data where a combination of scan angle and
  /// depth is missing or there twice; degenerate for fewer than two angles or depths.
  static Outcome<LepTable> make(std::span<const LepCalibrationPoint> points);

  std::span<const double> scan_angles() const { return angles_; }  ///< rad, rising
  std::span<const double> depths() const { return depths_; }       ///< m, rising

  /// Faults: out_of_range for a scan angle or image position outside the table; ambiguous where
  /// noise has made the table's image positions fold back, so that several depths fit.
  Outcome<LepTableDepth> invert(double scan_angle, double image_position) const;

 private:
  Outcome<LepTableDepth> invert_at(std::size_t angle, double image_position) const;
  double position(std::size_t angle, std::size_t depth) const {
    return positions_[angle * depths_.size() + depth];
  }

  std::vector<double> angles_;
  std::vector<double> depths_;
  std::vector<double> positions_;  ///< m; depths of one angle together
};

/// How far a table's depths are from a model's at the centres of its cells.
struct LepTableError {
  std::size_t cells = 0;
  std::size_t inverted = 0;  ///< the others have no depth, or several
  double rms = 0;            ///< m
  double largest = 0;        ///< m, with its sign
};

LepTableError table_error(const LepTable& table, const LepGeometry<double>& geometry,
                          const LepScanOrigin& origin);

/// The same for a table of the same angles and depths that holds the model's own image positions:
/// what interpolation alone does.
LepTableError interpolation_error(const LepTable& table, const LepGeometry<double>& geometry,
                                  const LepScanOrigin& origin);

}  // namespace ilss
