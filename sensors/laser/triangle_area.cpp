#include "sensors/laser/triangle_area.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

double cross(const ScanPoint& a, const ScanPoint& b) { return a.x * b.y - a.y * b.x; }

double square_distance(const ScanPoint& a, const ScanPoint& b) {
  return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
}

}  // namespace

void TriangleArea::Options::declare(OptionVisitor& visit) {
  visit("area", area, "U_t: between contour and chord of a support", {.unit = "m^2", .minimum = 0});
  visit("deviations_of_area", deviations_of_area,
        "U_t is at least so many standard deviations of a reading times the chord", {.minimum = 0});
  visit("absolute", absolute, "whether areas on opposite sides of a chord add up, not cancel");
  visit("least_support", least_support, "readings on either side",
        {.minimum = 1, .maximum = 1000000});
  visit("most_support", most_support, "readings on either side",
        {.minimum = 1, .maximum = 1000000});
  visit("longest_support", longest_support, "on either side", {.unit = "m", .minimum = 0});
  visit("corners", corners, "what a corner must be");
}

void TriangleArea::update(std::span<const ScanPoint> points, const LaserNoise& noise) {
  points_ = points;
  variance_.resize(points.size());
  areas_.resize(points.size());
  double area = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) area += cross(points[i - 1], points[i]) / 2;
    areas_[i] = area;
    variance_[i] = std::max(noise.range_variance,
                            points[i].range * points[i].range * noise.bearing_variance);
  }
}

double TriangleArea::area(std::size_t from, std::size_t to) const {
  return areas_[to] - areas_[from] - cross(points_[from], points_[to]) / 2;
}

double TriangleArea::absolute_area(std::size_t from, std::size_t to) const {
  const ScanPoint& first = points_[from];
  const double dx = points_[to].x - first.x;
  const double dy = points_[to].y - first.y;
  double sum = 0;
  double before = 0;
  for (std::size_t j = from + 1; j <= to; ++j) {
    const ScanPoint& point = points_[j];
    const double across = dx * (point.y - first.y) - dy * (point.x - first.x);
    const ScanPoint& last = points_[j - 1];
    const double along = dx * (point.x - last.x) + dy * (point.y - last.y);
    sum += std::abs((before + across) * along);
    before = across;
  }
  const double square = dx * dx + dy * dy;
  return square > 0 ? sum / (2 * square) : 0;
}

bool TriangleArea::supports(std::size_t from, std::size_t to) const {
  const double square = square_distance(points_[from], points_[to]);
  if (square > options_.longest_support * options_.longest_support) return false;
  const double enclosed = options_.absolute ? absolute_area(from, to) : area(from, to);
  const double noise = options_.deviations_of_area * options_.deviations_of_area * square *
                       std::max(variance_[from], variance_[to]);
  return enclosed * enclosed < std::max(options_.area * options_.area, noise);
}

void TriangleArea::find_supports() {
  const std::size_t count = points_.size();
  const auto least = static_cast<std::size_t>(options_.least_support);
  const auto most = std::max(least, static_cast<std::size_t>(options_.most_support));
  forward_.resize(count);
  backward_.resize(count);
  std::size_t end = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t lowest = std::min(i + least, count - 1);
    const std::size_t highest = std::min(i + most, count - 1);
    end = std::max(end, lowest);
    while (end < highest && supports(i, end + 1)) ++end;
    while (end > lowest && !supports(i, end)) --end;
    forward_[i] = end;
  }
  std::size_t begin = count - 1;
  for (std::size_t i = count; i-- > 0;) {
    const std::size_t highest = i - std::min(i, least);
    const std::size_t lowest = i - std::min(i, most);
    begin = std::min(begin, highest);
    while (begin > lowest && supports(begin - 1, i)) --begin;
    while (begin < highest && !supports(begin, i)) ++begin;
    backward_[i] = begin;
  }
}

void TriangleArea::find_turns() {
  const std::size_t count = points_.size();
  turn_.assign(count, 0);
  deviation_.assign(count, 0);
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const ScanPoint& point = points_[i];
    const ScanPoint& before = points_[backward_[i]];
    const ScanPoint& after = points_[forward_[i]];
    const double bx = point.x - before.x;
    const double by = point.y - before.y;
    const double fx = after.x - point.x;
    const double fy = after.y - point.y;
    const double bb = bx * bx + by * by;
    const double ff = fx * fx + fy * fy;
    if (!(bb > 0) || !(ff > 0)) continue;
    const double product = std::sqrt(bb * ff);
    const double sine = (bx * fy - by * fx) / product;
    // Beyond a right angle the sine falls again; the turn does not.
    turn_[i] = bx * fx + by * fy >= 0 ? sine : std::copysign(2 - std::abs(sine), sine);
    deviation_[i] = std::sqrt(variance_[i] * 2 * (1 / bb + 1 / ff + 1 / product));
  }
}

void TriangleArea::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                           std::vector<ReadingRun>& runs) {
  update(points, noise);
  find_supports();
  find_turns();
  segments_.segment(points, noise, turn_, deviation_, runs);
}

}  // namespace ilss
