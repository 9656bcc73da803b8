// The published extended Kalman filter for line extraction, as printed: a reference to compare
// with.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/range/feature_estimates.h"
#include "sensors/range/range_scan.h"

namespace ilss {

/// A line in the projection frame (origin where the rays start, turned with the head): rho (m) and
/// phi (rad), with covariance.
struct PolarLine {
  Eigen::Vector2d state;
  Eigen::Matrix2d covariance;
};

/// Where the axis of the head lies, seen from the projection frame: [r0, phi0] of eq. 17, phi0 in
/// the form that the geometry needs, atan2(-z0, -x0).
struct HeadAxis {
  double distance = 0;   ///< r0 (m)
  double direction = 0;  ///< phi0 (rad)
};

/// The state prediction over a rotation of the head by `turn` (rad), eq. 20 to 25, with encoder
/// noise of sd `encoder_std` (rad).
PolarLine predict_over_rotation(const PolarLine& line, const HeadAxis& axis, double turn,
                                double encoder_std);

/// What a line predicts of a reading at `bearing` (rad, from x), eq. 27 and 30, and the innovation.
struct PolarInnovation {
  double value;                 ///< nu = r - rho / cos(phi - theta) (m), eq. 28
  Eigen::RowVector2d jacobian;  ///< of the expected range, eq. 30
  double variance;              ///< S (m²), eq. 29
};
PolarInnovation polar_innovation(const PolarLine& line, double bearing, double range,
                                 double range_variance);

/// Update by a validated reading, eq. 34 to 36.
PolarLine update(const PolarLine& line, const PolarInnovation& innovation);

/// A reading in polar coordinates of the projection frame, as the filter takes it.
struct PolarReading {
  double bearing;   ///< theta (rad, from x towards z)
  double range;     ///< r (m)
  double variance;  ///< R (m²)
  double head;      ///< rad
};

/// The line through the first readings, in the frame of the last of them, eq. 38 to 40. Nothing
/// where they do not determine one.
std::optional<PolarLine> batch_line(std::span<const PolarReading> readings, const HeadAxis& axis);

/// Estimator: Pears' recursive line extraction. State (rho, phi) in the projection frame; the
/// head's rotation is the process; each reading passes the validation gate nu² / S <= g² (eq. 33)
/// and updates the line, or starts a new one with a batch of `batch_readings`. With
/// `cluster_gate`, the paper's proposal: segments of a scan whose lines are within that many
/// standard deviations of each other are joined by a weighted mean in (rho, phi).
///
/// Its stated errors are far too small: the filter is linearised about a noisy start, and variances
/// come from the noisy range. `line_extractor` is what to use. As in the paper, errors that the
/// scan's readings share are not considered.
/// Output frame: the scan's. Faults: as `line_extractor`; no_detection where a scan has fewer than
/// `batch_readings` readings.
class EkfLineExtractor final : public Module {
 public:
  static constexpr std::string_view name = "ekf_line_extractor";
  static constexpr std::string_view description =
      "the published Kalman filter for line segments, as a reference; its errors are not to be "
      "trusted";
  static constexpr std::string_view reference = "Pears 1997, sec. 4";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr bool severs = true;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_detection};

  struct Options {
    double gate = 3;
    std::int64_t batch_readings = 5;
    double encoder_std = 0;
    std::optional<double> cluster_gate;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit EkfLineExtractor(const Options& options) : options_(options) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  void extract(std::span<const RangeReading> readings, const RangeScan<double>& scan);
  void cluster();

  Options options_;
  std::vector<PolarReading> polar_;
  std::vector<FittedSegment> segments_;
};

}  // namespace ilss
