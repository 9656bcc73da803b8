// Finds a wall target in an image to about a pixel, and the pixels that measure it.
#pragma once

#include <array>
#include <vector>

#include "framework/module/outcome.h"
#include "sensors/camera/band_fit.h"

namespace ilss {

/// A dark band found to about a pixel, and the pixels to fit it to.
struct DetectedBand {
  std::array<StraightEdge, 2> edges;
  std::vector<BandWindow> windows;
};

/// A target's line and its stripes in order of column. The line's windows keep clear of the
/// stripes and the stripes' of the line.
struct DetectedTarget {
  DetectedBand line;
  std::vector<DetectedBand> stripes;
};

/// Looks for a dark, nearly horizontal line crossed by dark upright stripes, on a brighter wall:
/// pixels darker than the threshold that best parts the image's levels in two (Otsu 1979) give
/// runs down each column; the line is the straight one through the centres of most (random pairs of
/// them, consensus), the stripes are where it is dark above and below the line. Stripes cut off by
/// the image's border are left out. Fault: `no_detection`.
Outcome<DetectedTarget> detect_target(const ImageView& view, const Image<double>& camera);

}  // namespace ilss
