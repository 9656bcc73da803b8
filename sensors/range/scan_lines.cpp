#include "sensors/range/scan_lines.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

struct Point {
  double x;
  double z;
};

Point point_of(const RangeReading& reading) {
  return {reading.origin_x + std::cos(reading.bearing) / reading.inverse_range,
          reading.origin_z + std::sin(reading.bearing) / reading.inverse_range};
}

double distance(const RangeReading& a, const RangeReading& b) {
  const Point p = point_of(a);
  const Point q = point_of(b);
  return std::hypot(p.x - q.x, p.z - q.z);
}

/// The inverse range at which a reading's ray meets a line.
double expected(const RangeReading& reading, const InverseLine& m) {
  return (m.x * std::cos(reading.bearing) + m.z * std::sin(reading.bearing)) /
         (1 - m.x * reading.origin_x - m.z * reading.origin_z);
}

}  // namespace

ScanLines::ScanLines(const ScanLinesRule& rule) : rule_(rule), segmentation_(rule.segmentation) {}

void ScanLines::begin(double noise_correlation) {
  noise_correlation_ = noise_correlation;
  noise_factor_ = (1 + noise_correlation) / (1 - noise_correlation);
  readings_.clear();
  sums_.clear();
  segmentation_.clear();
  count_ = 0;
}

/// Whether readings are missing before this one and what lies between may be nothing.
bool ScanLines::is_gap(const RangeReading& reading) const {
  if (readings_.size() < 2) return false;
  const RangeReading& last = readings_.back();
  const RangeReading& before = readings_[readings_.size() - 2];
  constexpr double missing = 1.5;  // steps
  if (std::abs(reading.bearing - last.bearing) <= missing * std::abs(last.bearing - before.bearing))
    return false;
  return distance(last, reading) > rule_.max_gap;
}

bool ScanLines::add(const RangeReading& reading) {
  const bool gap = is_gap(reading);
  readings_.push_back(reading);
  sums_.add(std::cos(reading.bearing), std::sin(reading.bearing), reading.origin_x,
            reading.origin_z, reading.inverse_range,
            1 / (reading.deviation * reading.deviation * noise_factor_));
  if (gap) {
    segmentation_.break_before_last(sums_);
    return true;
  }
  return segmentation_.advance(sums_);
}

LineInformation ScanLines::information_of(std::span<const ReadingRun> runs) const {
  LineInformation sum;
  for (const ReadingRun& run : runs) sum = sum + sums_.of(run.begin, run.end);
  return sum;
}

FittedSegment& ScanLines::new_segment() {
  if (count_ == segments_.size()) segments_.emplace_back();
  FittedSegment& segment = segments_[count_++];
  segment.runs.clear();
  return segment;
}

/// Whether a run goes on with the segment before it: one line for both costs less than two.
bool ScanLines::joins(const FittedSegment& before, const ReadingRun& next,
                      LineInformation& information) {
  const std::size_t last = before.runs.back().end - 1;
  const LineInformation more = sums_.of(next.begin, next.end);
  const LineInformation both = information + more;
  if (both.chi_squared() - information.chi_squared() - more.chi_squared() >=
      rule_.segmentation.evidence)
    return false;
  if (next.begin != last + 1 && distance(readings_[last], readings_[next.begin]) > rule_.max_gap)
    return false;
  information = both;
  return true;
}

void ScanLines::join_pieces() {
  count_ = 0;
  LineInformation information;
  for (const ReadingRun& run : segmentation_.runs()) {
    if (run.size() < rule_.segmentation.least_readings) continue;
    const double as_outliers = rule_.segmentation.outlier_cost * static_cast<double>(run.size());
    if (sums_.of(run.begin, run.end).chi_squared() + rule_.segmentation.evidence > as_outliers)
      continue;
    if (count_ > 0 && joins(segments_[count_ - 1], run, information)) {
      segments_[count_ - 1].runs.push_back(run);
      continue;
    }
    new_segment().runs.push_back(run);
    information = sums_.of(run.begin, run.end);
  }
}

/// Where the range jumps between two segments, the last readings before and the first ones after
/// may hold light from both surfaces.
void ScanLines::drop_mixed_readings() {
  const std::size_t mixed = rule_.mixed_readings;
  const std::size_t least = rule_.segmentation.least_readings;
  for (std::size_t i = 0; i + 1 < count_; ++i) {
    ReadingRun& before = segments_[i].runs.back();
    ReadingRun& after = segments_[i + 1].runs.front();
    const RangeReading& last = readings_[before.end - 1];
    const RangeReading& first = readings_[after.begin];
    const InverseLine a = information_of(segments_[i].runs).line();
    const InverseLine b = information_of(segments_[i + 1].runs).line();
    const double jump = std::min(std::abs(expected(last, a) - expected(last, b)),
                                 std::abs(expected(first, a) - expected(first, b)));
    constexpr double clearly = 5;  // standard deviations of a reading
    if (jump < clearly * std::max(last.deviation, first.deviation)) continue;
    if (before.size() >= least + mixed) before.end -= mixed;
    if (after.size() >= least + mixed) after.begin += mixed;
  }
}

void ScanLines::fit() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    FittedSegment& segment = segments_[i];
    const auto fitted =
        fit_line(readings_, segment.runs, information_of(segment.runs).line(), noise_correlation_);
    if (!fitted) continue;
    segment.fit = *fitted;
    segment.first = segment.runs.front().begin;
    segment.last = segment.runs.back().end - 1;
    if (kept != i) std::swap(segments_[kept], segments_[i]);
    ++kept;
  }
  count_ = kept;
}

void ScanLines::finish() {
  if (readings_.empty()) return;
  segmentation_.refine(sums_);
  join_pieces();
  drop_mixed_readings();
  fit();
}

}  // namespace ilss
