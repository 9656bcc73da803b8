// Maximum-likelihood fit of a dark band with straight edges to an image's grey levels.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "sensors/camera/image_view.h"
#include "sensors/camera/straight_edge.h"

namespace ilss {

/// The share of a unit pixel that lies before an edge, whose position is `distance` beyond the
/// pixel's centre and changes by `slope` per pixel along; and its derivatives.
struct PixelShare {
  double share;
  double by_distance;
  double by_slope;
};
PixelShare share_before_edge(double distance, double slope);

/// The pixels at one position along the band that take part: across in [begin, end).
struct BandWindow {
  int along;
  int begin;
  int end;
};

/// A band as fitted. `edges` has the edge at smaller across first; its four numbers (offset and
/// slope of the first edge, then of the second) have the given covariance (pixels), and change with
/// the camera's components (in Image's order) as `by_camera` says.
struct BandFit {
  std::array<StraightEdge, 2> edges;
  Eigen::Matrix4d covariance;
  Eigen::Matrix<double, 4, dimension_of<Image>> by_camera;
  double contrast;  ///< grey levels from band to background
  double noise;     ///< standard deviation of the residuals, at least the rounding's
};

/// Fits edges, contrast and a background with gradients to the windows by Gauss-Newton, the model
/// of a pixel being the exact share of its square that the band covers. The covariance is
/// sigma² (JᵀJ)⁻¹ with sigma² from the residuals, at least `least_noise`² and the 1/12 of rounding.
/// `start` gives the edges to start from, right to about a pixel. `with_camera` asks for
/// `by_camera`. Nothing if the windows do not determine the band or no optimum is found.
std::optional<BandFit> fit_band(const ImageView& view, const Image<double>& camera,
                                const std::array<StraightEdge, 2>& start,
                                const std::vector<BandWindow>& windows, double least_noise,
                                bool with_camera);

}  // namespace ilss
