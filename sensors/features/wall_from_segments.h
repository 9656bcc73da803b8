// One wall out of a scan's segments, so that range sensors join the comparison of wall poses.
#pragma once

#include <array>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/features/range_features.h"
#include "sensors/wall/wall_points.h"

namespace ilss {

/// Picks a line segment: the one that the ray from the frame's origin at `bearing` meets or,
/// without a bearing, the longest; and gives its two ends as wall points, with their lineage.
/// Output frame: the input's. Faults: no_detection where no segment is there.
class WallFromSegments final : public Module {
 public:
  static constexpr std::string_view name = "wall_from_segments";
  static constexpr std::string_view description =
      "the longest line segment, or the one at a bearing, as wall points";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::no_detection};

  struct Options {
    std::optional<double> bearing;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit WallFromSegments(const Options& options) : options_(options) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  Options options_;
};

}  // namespace ilss
