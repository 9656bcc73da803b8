#include "sensors/range/scan_lines.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

struct PlanePoint {
  double x;
  double z;
};

PlanePoint point_of(const RangeReading& reading) {
  return {reading.origin_x + std::cos(reading.bearing) / reading.inverse_range,
          reading.origin_z + std::sin(reading.bearing) / reading.inverse_range};
}

double distance(const RangeReading& a, const RangeReading& b) {
  const PlanePoint p = point_of(a);
  const PlanePoint q = point_of(b);
  return std::hypot(p.x - q.x, p.z - q.z);
}

/// The inverse range at which a reading's ray meets a line.
double expected(const RangeReading& reading, const InverseLine& m) {
  return (m.x * std::cos(reading.bearing) + m.z * std::sin(reading.bearing)) /
         (1 - m.x * reading.origin_x - m.z * reading.origin_z);
}

double difference(const RangeReading& reading, const InverseLine& a, const InverseLine& b) {
  return expected(reading, a) - expected(reading, b);
}

}  // namespace

ScanLines::ScanLines(const ScanLinesRule& rule) : rule_(rule), segmentation_(rule.segmentation) {}

void ScanLines::begin(const RangeNoise& noise, double beam_width) {
  beam_width_ = beam_width;
  noise_ = noise;
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
            1 / (reading.deviation * reading.deviation * noise_.factor()));
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
  segment.arc.reset();
  segment.mixed_before = 0;
  segment.mixed_after = 0;
  segment.meets_before = false;
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
  const bool has_gap = next.begin != last + 1 || segmentation_.is_behind_gap(next.begin);
  if (has_gap && distance(readings_[last], readings_[next.begin]) > rule_.max_gap) return false;
  information = both;
  return true;
}

void ScanLines::join_pieces() {
  count_ = 0;
  LineInformation information;
  for (const ReadingRun& run : segmentation_.runs()) {
    if (run.size() < rule_.segmentation.least_readings) continue;
    const double cost_as_outliers =
        rule_.segmentation.outlier_cost * static_cast<double>(run.size());
    if (sums_.of(run.begin, run.end).chi_squared() + rule_.segmentation.evidence > cost_as_outliers)
      continue;
    if (count_ > 0 && joins(segments_[count_ - 1], run, information)) {
      segments_[count_ - 1].runs.push_back(run);
      continue;
    }
    new_segment().runs.push_back(run);
    information = sums_.of(run.begin, run.end);
  }
}

/// How many readings at an end of a surface may hold light of two surfaces: those within the beam's
/// width, as it is seen from the sensor. `inwards` is the neighbour on the surface.
std::size_t ScanLines::mixed_readings(std::size_t reading, std::size_t inwards) const {
  const double step = std::abs(readings_[reading].bearing - readings_[inwards].bearing);
  const double zone = beam_width_ * readings_[reading].inverse_range;
  if (zone == 0 || !(step > 0)) return 0;
  constexpr double most = 1000;
  return static_cast<std::size_t>(std::min(zone / step, most)) + 1;
}

/// Settles how one segment ends and the next begins, by their lines without the readings next to
/// the end, which may hold light of both. Either the lines meet there, a corner: then the readings
/// up to their intersection belong to one and those behind it to the other; the lines, which all
/// readings determine, tell that better than the few readings next to the end, whose noise the best
/// end follows. Or the range jumps, or nothing is there between: then what may be mixed is left
/// out.
void ScanLines::settle_end(FittedSegment& first, FittedSegment& second) {
  ReadingRun& before = first.runs.back();
  ReadingRun& after = second.runs.front();
  const std::size_t least = rule_.segmentation.least_readings;
  const std::size_t mixed = std::max(mixed_readings(before.end - 1, before.end - 2),
                                     mixed_readings(after.begin, after.begin + 1));
  const std::size_t mixed_before = before.size() >= least + mixed ? mixed : 0;
  const std::size_t mixed_after = after.size() >= least + mixed ? mixed : 0;
  const auto clean_line = [&](const FittedSegment& segment, std::size_t begin, std::size_t end) {
    return (information_of(segment.runs) - sums_.of(begin, end)).line();
  };
  const InverseLine a = clean_line(first, before.end - mixed_before, before.end);
  const InverseLine b = clean_line(second, after.begin, after.begin + mixed_after);
  const bool both_lines = !first.arc && !second.arc && !segmentation_.is_behind_gap(after.begin);
  if (both_lines && before.end == after.begin) {
    if (const auto corner = find_corner(before, after, a, b)) {
      before.end = after.begin = *corner;
      second.meets_before = true;
      return;
    }
  }
  constexpr double least_jump = 5;  // standard deviations of a reading
  const RangeReading& last = readings_[before.end - 1 - mixed_before];
  const RangeReading& next = readings_[after.begin + mixed_after];
  const double jump = std::min(std::abs(difference(last, a, b)), std::abs(difference(next, a, b)));
  if (both_lines && jump < least_jump * std::min(last.deviation, next.deviation)) {
    second.meets_before = before.end == after.begin;
    return;
  }
  before.end -= mixed_before;
  after.begin += mixed_after;
  first.mixed_after = mixed_before;
  second.mixed_before = mixed_after;
}

/// The first reading of `after` if the lines a and b meet near its present begin and that costs
/// little.
std::optional<std::size_t> ScanLines::find_corner(const ReadingRun& before, const ReadingRun& after,
                                                  const InverseLine& a,
                                                  const InverseLine& b) const {
  const std::size_t least = rule_.segmentation.least_readings;
  const double sign = difference(readings_[before.begin], a, b);
  std::size_t corner = before.end;
  while (corner > before.begin && difference(readings_[corner - 1], a, b) * sign < 0) --corner;
  while (corner < after.end && difference(readings_[corner], a, b) * sign > 0) ++corner;
  if (corner < before.begin + least || corner + least > after.end) return std::nullopt;
  const double now = sums_.of(before.begin, before.end).chi_squared(a) +
                     sums_.of(after.begin, after.end).chi_squared(b);
  const double then =
      sums_.of(before.begin, corner).chi_squared(a) + sums_.of(corner, after.end).chi_squared(b);
  if (then > now + rule_.segmentation.outlier_cost) return std::nullopt;
  return corner;
}

void ScanLines::settle_ends() {
  for (std::size_t i = 0; i + 1 < count_; ++i) settle_end(segments_[i], segments_[i + 1]);
}

double ScanLines::cost(const FittedSegment& segment) const {
  // A circle has three parameters where a line has two.
  const double evidence = rule_.segmentation.evidence;
  if (segment.arc) return segment.arc->chi_squared / noise_.factor() + 1.5 * evidence;
  return information_of(segment.runs).chi_squared() + evidence;
}

/// Whether a circle through two neighbouring lines could be near both: with their angle as its turn
/// it has the curvature k = 2 angle / (L1 + L2) and departs from a chord of length L by k L² /
/// sqrt(720) (root mean square), which must not be far beyond the noise. Costs far less than a fit.
bool ScanLines::may_be_round(const FittedSegment& a, const FittedSegment& b) const {
  if (a.arc || b.arc) return true;
  const auto length = [&](const FittedSegment& s) {
    return distance(readings_[s.runs.front().begin], readings_[s.runs.back().end - 1]);
  };
  const InverseLine la = information_of(a.runs).line();
  const InverseLine lb = information_of(b.runs).line();
  const double angle = std::abs(std::atan2(la.x * lb.z - la.z * lb.x, la.x * lb.x + la.z * lb.z));
  const double curvature = 2 * angle / (length(a) + length(b));
  if (curvature * rule_.arc.largest_radius < 0.5 || curvature * rule_.arc.least_radius > 2)
    return false;
  double expected_cost = 0;
  for (const FittedSegment* segment : {&a, &b}) {
    const ReadingRun& run = segment->runs.front();
    const RangeReading& middle = readings_[run.begin + run.size() / 2];
    const double l = length(*segment);
    const double deviation = middle.deviation / (middle.inverse_range * middle.inverse_range);
    const double departure = curvature * l * l / std::sqrt(720.0) / deviation;
    expected_cost += static_cast<double>(run.size()) * departure * departure;
  }
  return expected_cost < 4 * rule_.segmentation.evidence + cost(a) + cost(b);
}

/// Makes `before` the arc through the readings of both, if one circle costs less than the two. At
/// either end a few readings may be left out: there a ray meets the limb, or the beam what is
/// behind it.
bool ScanLines::join_to_arc(FittedSegment& before, const FittedSegment& after) const {
  std::size_t begin = before.runs.front().begin;
  std::size_t end = after.runs.back().end;
  const std::size_t middle_begin = before.runs.back().end;
  const std::size_t middle_end = after.runs.front().begin;
  const double outlier_cost = rule_.segmentation.outlier_cost;
  if (distance(readings_[middle_begin - 1], readings_[middle_end]) > rule_.max_gap) return false;
  double allowed =
      cost(before) + cost(after) + outlier_cost * static_cast<double>(middle_end - middle_begin);
  constexpr double largest_end_residual = 3.5;  // standard deviations
  constexpr std::size_t most_dropped = 12;
  for (std::size_t dropped = 0; dropped <= most_dropped; ++dropped) {
    const auto arc = fit_arc(std::span(readings_).subspan(begin, end - begin), rule_.arc, noise_);
    if (!arc) return false;
    const double at_begin = std::abs(arc_residual(readings_[begin], arc->circle));
    const double at_end = std::abs(arc_residual(readings_[end - 1], arc->circle));
    if (std::max(at_begin, at_end) < largest_end_residual) {
      FittedSegment joined;
      joined.arc = arc;
      if (cost(joined) > allowed) return false;
      before.arc = arc;
      before.runs = {{begin, end}};
      return true;
    }
    if (end - begin <= rule_.segmentation.least_readings) return false;
    // What grazes the circle says little of it and costs nothing.
    if (std::isfinite(std::max(at_begin, at_end))) allowed -= outlier_cost;
    if (at_begin > at_end)
      ++begin;
    else
      --end;
  }
  return false;
}

void ScanLines::find_arcs() {
  for (bool changed = true; changed;) {
    changed = false;
    std::size_t kept = 0;
    for (std::size_t i = 1; i < count_; ++i) {
      FittedSegment& before = segments_[kept];
      FittedSegment& after = segments_[i];
      if (may_be_round(before, after) && join_to_arc(before, after))
        changed = true;
      else if (++kept != i)
        std::swap(segments_[kept], after);
    }
    count_ = std::min(count_, kept + 1);
  }
}

bool ScanLines::fit(FittedSegment& segment) const {
  const auto fitted =
      fit_line(readings_, segment.runs, information_of(segment.runs).line(), noise_);
  if (!fitted) return false;
  segment.fit = *fitted;
  segment.first = segment.runs.front().begin;
  segment.last = segment.runs.back().end - 1;
  return true;
}

bool ScanLines::fit_run(const ReadingRun& run, FittedSegment& segment) const {
  if (run.size() < rule_.segmentation.least_readings) return false;
  segment.arc.reset();
  segment.runs.assign(1, run);
  return fit(segment);
}

void ScanLines::fit_all() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!fit(segments_[i])) continue;
    if (kept != i) std::swap(segments_[kept], segments_[i]);
    ++kept;
  }
  count_ = kept;
}

void ScanLines::finish() {
  if (readings_.empty()) return;
  segmentation_.refine(sums_);
  join_pieces();
  if (rule_.arc.largest_radius > 0) find_arcs();
  settle_ends();
  fit_all();
}

}  // namespace ilss
