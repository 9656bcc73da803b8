// The wall's trace from the image rows of three target points.
#pragma once

#include "framework/module/function_module.h"
#include "sensors/camera/target_rows.h"
#include "sensors/wall/wall_points.h"

namespace ilss {

/// The wall line that a camera sees (Henderson & Dekhil 1997, sec. 2.2), in the camera's plane with
/// x to the right and z forward:
///   z_i = f Y0 / y_i,  sin alpha = (z_l - z_r) / D0,
///   points (0, z_c) and (s cos alpha, z_c - s sin alpha)
/// with target height Y0, stripe spacing D0 and point spacing s. The second point's sign is the
/// one that a farther left stripe calls for; the paper prints the mirror image. Its printed
/// variance of alpha lacks 1 / D0² of the chain rule; here the derivatives are automatic.
/// Faults: `degenerate` where y is 0, `out_of_range` where the line would lie behind the camera or
/// |z_l - z_r| >= D0.
class VisionLine {
 public:
  static constexpr std::string_view name = "vision_line";
  static constexpr std::string_view description =
      "wall line from the image rows of three points of a target";
  static constexpr std::string_view reference = "Henderson & Dekhil 1997, sec. 2.2";
  static constexpr std::array<std::string_view, 1> inputs = {"rows"};
  static constexpr std::array faults = {FaultKind::degenerate, FaultKind::out_of_range,
                                        FaultKind::not_finite};

  template <typename T>
  struct Parameters {
    T target_height, stripe_spacing, focal_length, point_spacing;
    static constexpr std::string_view name = "vision_line_parameters";
    static constexpr auto fields =
        Fields{{"target_height", "m", "of the line above the optical axis"},
               {"stripe_spacing", "m", "from centre to centre of neighbouring stripes"},
               {"focal_length", "m", "of the lens"},
               {"point_spacing", "m", "from the first point to the second", 1}};
  };

  template <typename T>
  Outcome<WallPoints<T>> operator()(const Parameters<T>& parameters,
                                    const TargetRows<T>& rows) const {
    using std::sqrt;
    for (const T* y : {&rows.y_l, &rows.y_c, &rows.y_r}) {
      if (scalar_value(*y) == 0)
        return Fault{FaultKind::degenerate, "the line lies on the horizon: its depth is not known"};
      if (scalar_value(*y) * scalar_value(parameters.target_height) *
              scalar_value(parameters.focal_length) <=
          0)
        return Fault{FaultKind::out_of_range,
                     "the line shows on the wrong side of the optical axis for its height"};
    }
    const T scale = parameters.focal_length * parameters.target_height;
    const T z_c = scale / rows.y_c;
    const T sine = (scale / rows.y_l - scale / rows.y_r) / parameters.stripe_spacing;
    if (!(scalar_value(sine) > -1 && scalar_value(sine) < 1))
      return Fault{FaultKind::out_of_range,
                   "the stripes' depths differ by their spacing or more; is the spacing right?"};
    const T cosine = sqrt(1.0 - sine * sine);
    return WallPoints<T>{T(0.0), z_c, parameters.point_spacing * cosine,
                         z_c - parameters.point_spacing * sine};
  }

  /// Exact derivatives: d cos alpha = -tan alpha d sin alpha, so whatever changes sin alpha moves
  /// the second point by (-s tan alpha, -s) d sin alpha.
  void jacobian(const Parameters<double>& parameters, const TargetRows<double>& rows,
                const WallPoints<double>& points, std::span<double> out) const {
    // Reciprocals in common: divisions are what this costs.
    const double spacing = parameters.point_spacing;
    const double scale = parameters.focal_length * parameters.target_height;
    const double per_scale_and_spacing = 1 / (scale * parameters.stripe_spacing);
    const double per_scale = parameters.stripe_spacing * per_scale_and_spacing;
    const double per_stripe_spacing = scale * per_scale_and_spacing;
    const double per_height = parameters.focal_length * per_scale;
    const double per_focal_length = parameters.target_height * per_scale;
    const double scale_per_rows = scale / (rows.y_l * rows.y_r);
    const double z_l = scale_per_rows * rows.y_r;
    const double z_r = scale_per_rows * rows.y_l;
    const double sine = (z_l - z_r) * per_stripe_spacing;
    const double cosine = std::sqrt(1.0 - sine * sine);
    const double tangent = sine / cosine;
    // How z_c and sin alpha change with each argument, parameters first; dz/dy = -z² / (f Y0).
    const double depth[] = {points.z1 * per_height,
                            0,
                            points.z1 * per_focal_length,
                            0,
                            0,
                            -points.z1 * points.z1 * per_scale,
                            0};
    const double turn[] = {sine * per_height,
                           -sine * per_stripe_spacing,
                           sine * per_focal_length,
                           0,
                           -z_l * z_l * per_scale_and_spacing,
                           0,
                           z_r * z_r * per_scale_and_spacing};
    constexpr std::size_t of_spacing = 3;
    for (std::size_t k = 0; k < std::size(depth); ++k) {
      double* column = out.data() + 4 * k;
      column[0] = 0;
      column[1] = depth[k];
      column[2] = -spacing * tangent * turn[k] + (k == of_spacing ? cosine : 0);
      column[3] = depth[k] - spacing * turn[k] - (k == of_spacing ? sine : 0);
    }
  }
};

}  // namespace ilss
