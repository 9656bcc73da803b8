// Finds a wall target in an image to a fraction of a pixel.
#pragma once

#include <array>
#include <optional>

#include "framework/module/module_type.h"
#include "sensors/camera/image.h"
#include "sensors/camera/target_rows.h"

namespace ilss {

/// The rows of a wall target's line at the stripe left of the optical axis, at the axis and at the
/// stripe right of it (else at the two neighbouring stripes nearest to the axis); rows and columns
/// of an ideal lens, heights up from the optical axis in metres on the image plane.
///
/// The line's and each stripe's two straight edges are fitted to the grey levels by maximum
/// likelihood (band_fit.h), through the lens distortion. The line's centre is the mean of its edges
/// (heights project linearly at one column); a stripe's centre between edges at columns u1, u2,
/// where the line shows at heights y1, y2, is (u1/y1 + u2/y2) / (1/y1 + 1/y2), for depth goes as
/// 1/y. The covariance is what the fits' residuals support; the camera's own errors are mapped
/// through with the derivatives of the whole fit. The stripes must be upright in the image's ideal
/// geometry only as far as their crossing with the line is concerned: each edge has a slope.
/// Faults: `no_detection`, `degenerate` (a stripe on the optical axis' column, or the line on its
/// row), `bad_data` (the image's size and levels do not match).
class TargetPoints final : public Module {
 public:
  static constexpr std::string_view name = "target_points";
  static constexpr std::string_view description =
      "rows of a wall target's line at two stripes and the image's centre column";
  static constexpr std::string_view reference = "Henderson & Dekhil 1997, sec. 2.2";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::no_detection, FaultKind::degenerate,
                                        FaultKind::bad_data, FaultKind::no_error_known};

  struct Options {
    std::optional<double> row_std;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit TargetPoints(Options options) : options_(options) {}
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// From the expected image, with the noise that it states; at an operating point, `row_std` for
  /// each row independently.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;

 private:
  Options options_;
};

}  // namespace ilss
