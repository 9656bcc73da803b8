// What all segmenters have in common: from clusters of a scan to its segments.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "framework/module/module_type.h"
#include "sensors/laser/segment/segmented_points.h"

namespace ilss {

/// What a segment must have to be believed.
struct SegmentRule {
  std::int64_t least_readings = 10;
  double least_length = 0.5;  ///< m, between two of its first, middle and last points
  void declare(OptionVisitor& visit);
  bool accepts(std::span<const ScanPoint> segment) const;
};

/// A way to take a cluster apart. A struct with static `name`, `description` and `reference`,
/// `Options` that are declared like a module's, constructed from them; `segment` appends the runs
/// of a cluster's points that belong to one line or curve each: indices into `points`, in order,
/// without overlap; short ones too, those are left out later. Every point has a range above 0. The
/// vectors that it needs are kept from call to call.
template <typename A>
concept SegmentationAlgorithm = requires(A algorithm, std::span<const ScanPoint> points,
                                         const LaserNoise& noise, std::vector<ReadingRun>& runs) {
  typename A::Options;
  algorithm.segment(points, noise, runs);
};

/// The module of an algorithm. Input: a segmented_scan, as `breakpoints` gives it; output: the same
/// scan with each cluster's segments instead of the clusters. Segments of fewer than
/// `least_readings` or shorter than `least_length` are left out. Faults: bad_data where a number is
/// not finite or a range negative; no_detection where no segment is left.
template <SegmentationAlgorithm Algorithm>
class Segmenter final : public Module {
 public:
  static constexpr std::string_view name = Algorithm::name;
  static constexpr std::string_view description = Algorithm::description;
  static constexpr std::string_view reference = Algorithm::reference;
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_detection};

  struct Options {
    typename Algorithm::Options algorithm = {};
    SegmentRule rule = {};
    void declare(OptionVisitor& visit) {
      algorithm.declare(visit);
      rule.declare(visit);
    }
  };

  static Interface interface() {
    return {.inputs = {{"scan", &descriptor<SegmentedScan>()}},
            .output = &descriptor<SegmentedScan>(),
            .frame_of_input = 0};
  }

  explicit Segmenter(const Options& options) : algorithm_(options.algorithm), rule_(options.rule) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    if (auto read = scan_.read(*evaluation.inputs[0]); !read) return read;
    const LaserNoise noise = noise_of(evaluation.input(0));
    runs_.clear();
    for (const ReadingRun& cluster : scan_.runs()) {
      found_.clear();
      algorithm_.segment(scan_.points_of(cluster), noise, found_);
      for (const ReadingRun& run : found_) {
        const ReadingRun whole{cluster.begin + run.begin, cluster.begin + run.end};
        if (rule_.accepts(scan_.points_of(whole))) runs_.push_back(whole);
      }
    }
    if (runs_.empty()) return Fault{FaultKind::no_detection, "the scan has no segment"};
    scan_.write(evaluation, runs_, output);
    return {};
  }

 private:
  Algorithm algorithm_;
  SegmentRule rule_;
  SegmentedPoints scan_;
  std::vector<ReadingRun> found_;
  std::vector<ReadingRun> runs_;
};

}  // namespace ilss
