#include "sensors/scene/wall_target_patches.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

/// The line and the stripes as rectangles that may overlap.
std::vector<WallPatch> overlapping_patches(const Wall& wall) {
  std::vector<WallPatch> patches;
  for (const WallTarget& target : wall.targets) {
    const double middle =
        target.along + 0.5 * static_cast<double>(target.stripe_count - 1) * target.stripe_spacing;
    patches.push_back({middle - 0.5 * target.line_length, middle + 0.5 * target.line_length,
                       target.height - 0.5 * target.line_thickness,
                       target.height + 0.5 * target.line_thickness, target.reflectivity});
    for (std::int64_t stripe = 0; stripe < target.stripe_count; ++stripe) {
      const double centre = target.along + static_cast<double>(stripe) * target.stripe_spacing;
      patches.push_back({centre - 0.5 * target.stripe_width, centre + 0.5 * target.stripe_width,
                         target.stripe_bottom, target.stripe_top, target.reflectivity});
    }
  }
  const double length = std::hypot(wall.to.x - wall.from.x, wall.to.z - wall.from.z);
  for (WallPatch& patch : patches) {
    patch.along_begin = std::max(patch.along_begin, 0.0);
    patch.along_end = std::min(patch.along_end, length);
  }
  std::erase_if(patches, [](const WallPatch& patch) {
    return !(patch.along_begin < patch.along_end && patch.bottom < patch.top);
  });
  return patches;
}

void sort_unique(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Cuts a column of the wall, covered all along by each of `covering` (later ones in front), into
/// disjoint patches.
void cut_column(const std::vector<const WallPatch*>& covering, double begin, double end,
                std::vector<WallPatch>& out) {
  std::vector<double> heights;
  for (const WallPatch* patch : covering) {
    heights.push_back(patch->bottom);
    heights.push_back(patch->top);
  }
  sort_unique(heights);
  const std::size_t first = out.size();
  for (std::size_t i = 0; i + 1 < heights.size(); ++i) {
    const auto front =
        std::find_if(covering.rbegin(), covering.rend(), [&](const WallPatch* patch) {
          return patch->bottom <= heights[i] && heights[i + 1] <= patch->top;
        });
    if (front == covering.rend()) continue;
    const double reflectivity = (*front)->reflectivity;
    if (out.size() > first && out.back().top == heights[i] &&
        out.back().reflectivity == reflectivity)
      out.back().top = heights[i + 1];
    else
      out.push_back({begin, end, heights[i], heights[i + 1], reflectivity});
  }
}

}  // namespace

std::vector<WallPatch> target_patches(const Wall& wall) {
  const std::vector<WallPatch> overlapping = overlapping_patches(wall);
  std::vector<double> cuts;
  for (const WallPatch& patch : overlapping) {
    cuts.push_back(patch.along_begin);
    cuts.push_back(patch.along_end);
  }
  sort_unique(cuts);
  std::vector<WallPatch> result;
  std::vector<const WallPatch*> covering;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    covering.clear();
    for (const WallPatch& patch : overlapping)
      if (patch.along_begin <= cuts[i] && cuts[i + 1] <= patch.along_end)
        covering.push_back(&patch);
    cut_column(covering, cuts[i], cuts[i + 1], result);
  }
  return result;
}

}  // namespace ilss
