#include "sensors/camera/target_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sensors/camera/target_detection.h"

namespace ilss {
namespace {

constexpr std::size_t camera_dimension = dimension_of<Image>;

/// A camera's components that say what an ideal pixel's position means in metres.
template <typename T>
struct PixelScale {
  T pitch, principal_row, principal_column;
};

/// A fitted band's edges in T: across = offset + slope (along - reference).
template <typename T>
struct Band {
  std::array<T, 4> edges;
  double reference;
};

/// The column at which a stripe's edge crosses the line.
template <typename T>
T crossing_column(const Band<T>& line, const Band<T>& stripe, std::size_t edge) {
  const T line_offset = 0.5 * (line.edges[0] + line.edges[2]);
  const T line_slope = 0.5 * (line.edges[1] + line.edges[3]);
  const T& offset = stripe.edges[2 * edge];
  const T& slope = stripe.edges[2 * edge + 1];
  return (offset + slope * (line_offset - line_slope * line.reference - stripe.reference)) /
         (1.0 - slope * line_slope);
}

/// The line's height above the principal row at a column (pixels).
template <typename T>
T line_height(const Band<T>& line, const PixelScale<T>& scale, const T& column) {
  const T offset = 0.5 * (line.edges[0] + line.edges[2]);
  const T slope = 0.5 * (line.edges[1] + line.edges[3]);
  return scale.principal_row - (offset + slope * (column - line.reference));
}

/// The line's height at a stripe's centre, which lies midway on the wall, not in the image.
template <typename T>
T height_at_stripe(const Band<T>& line, const Band<T>& stripe, const PixelScale<T>& scale) {
  const T u1 = crossing_column(line, stripe, 0);
  const T u2 = crossing_column(line, stripe, 1);
  const T y1 = line_height(line, scale, u1);
  const T y2 = line_height(line, scale, u2);
  return line_height(line, scale, T((u1 * y2 + u2 * y1) / (y1 + y2)));
}

template <typename T>
TargetRows<T> target_rows(const Band<T>& line, const Band<T>& left, const Band<T>& right,
                          const PixelScale<T>& scale) {
  return {scale.pitch * height_at_stripe(line, left, scale),
          scale.pitch * line_height(line, scale, scale.principal_column),
          scale.pitch * height_at_stripe(line, right, scale)};
}

/// The neighbouring stripes on either side of the optical axis, else the two nearest to it.
Outcome<std::pair<std::size_t, std::size_t>> choose_stripes(
    const std::vector<DetectedBand>& stripes, double principal_column) {
  if (stripes.size() < 2)
    return Fault{FaultKind::no_detection, stripes.empty()
                                              ? "the line is crossed by no stripe, two are needed"
                                              : "the line is crossed by one stripe only"};
  constexpr double clearance = 0.5;
  std::size_t right = 0;
  for (const DetectedBand& stripe : stripes) {
    if (stripe.edges[0].offset - clearance < principal_column &&
        principal_column < stripe.edges[1].offset + clearance)
      return Fault{FaultKind::degenerate, "a stripe lies on the optical axis' column"};
    if (stripe.edges[1].offset < principal_column) ++right;
  }
  right = std::clamp<std::size_t>(right, 1, stripes.size() - 1);
  return std::pair{right - 1, right};
}

/// Fits a detected band and refuses what is not one: little contrast, or edges far from where they
/// were detected.
std::optional<BandFit> fit_detected(const ImageView& view, const Image<double>& camera,
                                    const DetectedBand& band, double least_noise,
                                    bool with_camera) {
  constexpr double least_contrast_to_noise = 3;
  constexpr double farthest = 2;
  auto fit = fit_band(view, camera, band.edges, band.windows, least_noise, with_camera);
  if (!fit || fit->contrast < least_contrast_to_noise * fit->noise) return std::nullopt;
  for (std::size_t i = 0; i < 2; ++i)
    if (std::abs(fit->edges[i].offset - band.edges[i].offset) > farthest) return std::nullopt;
  if (fit->edges[0].offset >= fit->edges[1].offset) return std::nullopt;
  return fit;
}

/// The three bands' numbers as variables 0 to 11, and the pixel scale as 12 to 14.
constexpr std::size_t band_variables = 12;
constexpr std::size_t all_variables = band_variables + 3;
using T = Dual<all_variables>;

Band<T> variable_band(const BandFit& fit, int first) {
  Band<T> band;
  band.reference = fit.edges[0].reference;
  for (std::size_t i = 0; i < 2; ++i) {
    const int variable = first + 2 * static_cast<int>(i);
    band.edges[2 * i] = T(fit.edges[i].offset, variable);
    band.edges[2 * i + 1] = T(fit.edges[i].slope, variable + 1);
  }
  return band;
}

/// The rows with their error: the fits' as fresh columns, the camera's mapped through.
void write_rows(const std::array<BandFit, 3>& fits, const Image<double>& camera,
                const Evaluation& evaluation, Output& output) {
  const TargetRows<T> rows =
      target_rows(variable_band(fits[0], 0), variable_band(fits[1], 4), variable_band(fits[2], 8),
                  PixelScale<T>{T(camera.pixel_pitch, 12), T(camera.principal_row, 13),
                                T(camera.principal_column, 14)});
  TargetRows<double> values{rows.y_l.a, rows.y_c.a, rows.y_r.a};
  Eigen::Matrix<double, 3, all_variables> by_variables;
  by_variables << rows.y_l.v.transpose(), rows.y_c.v.transpose(), rows.y_r.v.transpose();

  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Identity() * std::pow(camera.pixel_pitch * camera.position_std, 2);
  // pixel_pitch, principal_row and principal_column are the first components of Image.
  Eigen::Matrix<double, 3, camera_dimension> by_camera =
      Eigen::Matrix<double, 3, camera_dimension>::Zero();
  by_camera.leftCols<3>() = by_variables.rightCols<3>();
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Matrix<double, 3, 4> by_band =
        by_variables.middleCols<4>(4 * static_cast<Eigen::Index>(i));
    covariance += by_band * fits[i].covariance * by_band.transpose();
    by_camera += by_band * fits[i].by_camera;
  }
  Estimate& estimate = output.estimate;
  assign(estimate, values);
  const LineageTerm term{by_camera.data(), &evaluation.input(0).lineage};
  compose({&term, 1}, 3, estimate.lineage);
  estimate.lineage.add_noise(evaluation.fresh(0), covariance);
}

Outcome<> measure(const Evaluation& evaluation, double least_noise, Output& output) {
  const Samples& samples = evaluation.inputs[0]->samples;
  const Image<double> camera = payload_of<Image>(evaluation.input(0));
  const std::span<const std::uint8_t> levels = levels_of(*evaluation.inputs[0]);
  if (samples.shape.size() != 2 || levels.empty() ||
      levels.size() != samples.shape[0] * samples.shape[1])
    return Fault{FaultKind::bad_data,
                 "the image has no grey levels, or not rows x columns of them"};
  if (!(camera.pixel_pitch > 0) || !(camera.focal_length > 0))
    return Fault{FaultKind::bad_data, "the camera's pixel pitch and focal length must be above 0"};
  const ImageView view = horizontal_view(levels.data(), static_cast<int>(samples.shape[0]),
                                         static_cast<int>(samples.shape[1]));
  const auto target = detect_target(view, camera);
  if (!target) return target.fault();
  const auto pair = choose_stripes(target->stripes, camera.principal_column);
  if (!pair) return pair.fault();

  const bool with_camera = !evaluation.input(0).lineage.empty();
  const auto line = fit_detected(view, camera, target->line, least_noise, with_camera);
  if (!line)
    return Fault{FaultKind::no_detection, "what looked like the line has no two straight edges"};
  const ImageView across = view.transposed();
  const auto left =
      fit_detected(across, camera, target->stripes[pair->first], least_noise, with_camera);
  const auto right =
      fit_detected(across, camera, target->stripes[pair->second], least_noise, with_camera);
  if (!left || !right)
    return Fault{FaultKind::no_detection, "what looked like a stripe has no two straight edges"};
  write_rows({*line, *left, *right}, camera, evaluation, output);

  constexpr double horizon = 0.5;  // pixels
  for (const double y : output.estimate.value) {
    if (!std::isfinite(y))
      return Fault{FaultKind::degenerate, "the line and the stripes do not cross"};
    if (std::abs(y) < horizon * camera.pixel_pitch)
      return Fault{FaultKind::degenerate, "the line lies on the optical axis' row"};
  }
  return {};
}

}  // namespace

void TargetPoints::Options::declare(OptionVisitor& visit) {
  visit("row_std", row_std,
        "expected error of each row at an operating point, on the image plane; measured rows carry "
        "the error that their image supports",
        {.unit = "m", .minimum = 0});
}

Interface TargetPoints::interface() {
  return {{{"image", &descriptor<Image>(), {}, false}}, &descriptor<TargetRows>(), {}, 0};
}

Outcome<> TargetPoints::evaluate(const Evaluation& evaluation, Output& output) {
  return measure(evaluation, 0, output);
}

Outcome<> TargetPoints::expect(const Evaluation& evaluation, const Output* operating_point,
                               Output& output) {
  if (operating_point == nullptr) {
    const auto& noise = evaluation.inputs[0]->samples.standard_deviations;
    return measure(evaluation, noise.empty() ? 0 : *std::max_element(noise.begin(), noise.end()),
                   output);
  }
  if (!options_.row_std)
    return Fault{FaultKind::no_error_known,
                 "target_points knows its error from an image only: set row_std, or give the "
                 "operating point with std"};
  assign(output.estimate, payload_of<TargetRows>(operating_point->estimate));
  for (std::size_t i = 0; i < 3; ++i)
    output.estimate.lineage.add(evaluation.fresh(static_cast<std::uint32_t>(i)), i,
                                *options_.row_std);
  return {};
}

}  // namespace ilss
