// Range from an image row by calibration.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "framework/module/module_type.h"

namespace ilss {

/// The row of an image at which something shows.
template <typename T>
struct ImageRow {
  T row;
  static constexpr std::string_view name = "image_row";
  static constexpr std::string_view documentation = "row of an image, in pixels downwards";
  static constexpr auto fields = Fields{{"row", "1", "in pixels, downwards"}};
};

/// How far the wall is along the optical axis.
template <typename T>
struct WallRange {
  T range;
  static constexpr std::string_view name = "wall_range";
  static constexpr std::string_view documentation = "distance of the wall along the optical axis";
  static constexpr auto fields = Fields{{"range", "m", "along the optical axis"}};
};

/// The hyperbola row = horizon - scale / range, with scale = f Y0 / pitch for a line at height Y0,
/// and the covariance of (horizon, scale).
struct RowRangeFit {
  double horizon = 0;  ///< row of the optical axis, in pixels
  double scale = 0;    ///< pixels times metres
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  double row_std = 0;  ///< error of a row, given or from the residuals
};

/// Range from the row at which a target's line shows (Henderson & Dekhil 1997, figure 7): fits the
/// hyperbola to calibration pairs by weighted least squares, in which it is linear, and inverts it:
///   range = scale / (horizon - row)
/// The rows' error in the pairs is `row_std`, or what the residuals say. What the calibration left
/// uncertain is the same at every tick: persistent sources of this module.
/// Faults: `degenerate` (the pairs do not determine a hyperbola), `out_of_range` (a row on or below
/// the horizon's side).
class RangeCalibration final : public Module {
 public:
  static constexpr std::string_view name = "range_calibration";
  static constexpr std::string_view description =
      "range of a wall from the row of a target's line, by calibration pairs";
  static constexpr std::string_view reference = "Henderson & Dekhil 1997, figure 7";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::degenerate, FaultKind::out_of_range};

  struct Pair {
    double range = 0;
    double row = 0;
    void declare(OptionVisitor& visit);
  };
  struct Options {
    std::vector<Pair> pairs;
    std::optional<double> row_std;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit RangeCalibration(const Options& options) : fit_(fit(options)) {}
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// At an operating point (a range): the calibration's error and that of one row.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;

  /// Nothing where the pairs do not determine a hyperbola with rows above the horizon.
  static std::optional<RowRangeFit> fit(const Options& options);

 private:
  void add_calibration_error(const Evaluation& evaluation, double range, Estimate& estimate) const;

  std::optional<RowRangeFit> fit_;
};

}  // namespace ilss
