// Scans and what segmenters make of them, for tests.
#pragma once

#include <numbers>
#include <span>
#include <vector>

#include "sensors/laser/segment/breakpoints.h"
#include "sensors/laser/segment/segmenter.h"
#include "sensors/laser/simulate/generated_room.h"
#include "sensors/laser/simulate/visible_pieces.h"
#include "tests/sensors/module_run.h"

namespace ilss {

/// What the tests' lasers are like, unless they say otherwise: as in Núñez et al. 2009, sec. 5.
inline constexpr LaserErrors usual_errors{0.005, 0.1 * std::numbers::pi / 180, 0};

inline Output scan_output(std::span<const LaserBeam> beams,
                          const LaserErrors& errors = usual_errors) {
  Output output = output_of<LaserScan>({errors.range_std, errors.bearing_std, errors.quantum, 80});
  std::copy(beams.begin(), beams.end(), make_beams(output, beams.size()).begin());
  return output;
}

/// A segmented scan whose readings with a return all belong to one cluster.
inline Output cluster_output(std::span<const LaserBeam> beams,
                             const LaserErrors& errors = usual_errors) {
  Output output =
      output_of<SegmentedScan>({errors.range_std, errors.bearing_std, errors.quantum, 80});
  const std::span<SegmentedBeam> rows = make_rows<SegmentedBeam>(output, beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) rows[i] = {beams[i].bearing, beams[i].range, 1};
  return output;
}

/// Beams at even steps from the first bearing to the last, whose ranges a function gives.
template <typename Range>
std::vector<LaserBeam> beams_to(double first, double last, std::size_t count, Range range) {
  std::vector<LaserBeam> beams(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    beams[i].bearing = first + share * (last - first);
    beams[i].range = range(beams[i].bearing);
  }
  return beams;
}

/// The range of a beam to the line at `distance`, whose normal points to `direction`; 0 if none.
inline double range_to_line(double bearing, double distance, double direction) {
  const double cosine = std::cos(bearing - direction);
  return cosine > 1e-9 ? distance / cosine : 0;
}

/// The segments of a segmented scan, in the order of their numbers.
inline std::vector<ReadingRun> runs_of(const Output& scan) {
  std::vector<ReadingRun> runs;
  const std::span<const SegmentedBeam> beams = segmented_beams_of(scan);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const auto segment = static_cast<std::size_t>(beams[i].segment);
    if (segment == 0) continue;
    if (segment > runs.size())
      runs.push_back({i, i + 1});
    else
      runs.back().end = i + 1;
  }
  return runs;
}

/// Breakpoints and a segmenter behind them.
template <typename Algorithm>
class SegmenterChain {
 public:
  explicit SegmenterChain(typename Algorithm::Options options = {}, SegmentRule rule = {})
      : breakpoints_({}), segmenter_({options, rule}) {}

  ModuleRun operator()(const Output& scan) {
    ModuleRun clusters = run(breakpoints_, {.inputs = {&scan}});
    if (!clusters.outcome) return clusters;
    return run(segmenter_, {.inputs = {&clusters.output}});
  }
  std::vector<ReadingRun> runs(const Output& scan) { return runs_of((*this)(scan).output); }

 private:
  Breakpoints breakpoints_;
  Segmenter<Algorithm> segmenter_;
};

/// What an algorithm makes of one cluster.
template <typename Algorithm>
std::vector<ReadingRun> segment_cluster(Algorithm& algorithm, const Output& cluster) {
  ScanPoints buffer;
  std::vector<ReadingRun> runs;
  algorithm.segment(buffer.update(segmented_beams_of(cluster)), noise_of(cluster.estimate), runs);
  return runs;
}

inline double overlap(const ReadingRun& a, const ReadingRun& b) {
  const std::size_t begin = std::max(a.begin, b.begin);
  const std::size_t end = std::min(a.end, b.end);
  if (end <= begin) return 0;
  const auto common = static_cast<double>(end - begin);
  return common / (static_cast<double>(a.size() + b.size()) - common);
}

/// A scan of a room and what it truly shows.
struct RoomScan {
  Output scan;
  std::vector<VisiblePiece> pieces;
};

inline RoomScan scan_room(const Scene& room, const RayCaster& caster, const LaserSweep& sweep,
                          const ScenePose& laser, const LaserErrors& errors, std::uint64_t seed) {
  RoomScan result;
  std::vector<TracedBeam> traced;
  trace_beams(caster, sweep, {laser, {}}, traced);
  find_pieces(room, traced, result.pieces);
  std::vector<LaserBeam> beams(sweep.beams);
  simulate_scan(caster, sweep, {laser, {}}, errors, seed, beams);
  result.scan = scan_output(beams, errors);
  return result;
}

inline ReadingRun run_of(const VisiblePiece& piece) { return {piece.first, piece.last + 1}; }

}  // namespace ilss
