#include "sensors/laser/segment/triangle_area.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

double cross(const ScanPoint& a, const ScanPoint& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

void TriangleArea::Options::declare(OptionVisitor& visit) {
  visit("area", area, "U_t: between contour and chord of a support", {.unit = "m^2", .minimum = 0});
  visit("deviations_of_area", deviations_of_area,
        "U_t is at least so many standard deviations of a reading times the chord", {.minimum = 0});
  visit("absolute", absolute, "whether areas on opposite sides of a chord add up, not cancel");
  visit("support", support, "how long the triangles' sides may be");
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
    variance_[i] = place_variance(points[i], noise);
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
  const double x = points_[to].x - points_[from].x;
  const double y = points_[to].y - points_[from].y;
  const double enclosed = options_.absolute ? absolute_area(from, to) : area(from, to);
  const double noise = options_.deviations_of_area * options_.deviations_of_area * (x * x + y * y) *
                       std::max(variance_[from], variance_[to]);
  return enclosed * enclosed < std::max(options_.area * options_.area, noise);
}

void TriangleArea::find_turns() {
  turn_.assign(points_.size(), 0);
  deviation_.assign(points_.size(), 0);
  for (std::size_t i = 1; i + 1 < points_.size(); ++i) {
    const LocalVectors vectors =
        local_vectors(points_[regions_.backward()[i]], points_[i], points_[regions_.forward()[i]]);
    if (vectors.product == 0) continue;
    const double sine = vectors.cross / vectors.product;
    // Beyond a right angle the sine falls again; the turn does not.
    turn_[i] = vectors.dot >= 0 ? sine : std::copysign(2 - std::abs(sine), sine);
    deviation_[i] = vectors.deviation * std::sqrt(variance_[i]);
  }
}

void TriangleArea::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                           std::vector<ReadingRun>& runs) {
  update(points, noise);
  regions_.update(points, [this](std::size_t from, std::size_t to) { return supports(from, to); });
  find_turns();
  segments_.segment(points, noise, turn_, deviation_, runs);
}

}  // namespace ilss
