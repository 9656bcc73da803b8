#include "sensors/laser/segment/hough.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sensors/laser/segment/boundary_placement.h"

namespace ilss {
namespace {

/// Of a neighbourhood.
constexpr std::size_t least_neighbours = 5;
/// Votes on either side that one vote is clustered with, so that long clusters cost as many votes
/// as they have.
constexpr std::size_t cluster_reach = 1000;
/// Votes at more than 45 degrees from a line never belong to it, however little they know.
constexpr double least_cosine = 0.7;
constexpr int most_shifts = 20;
constexpr double shift_tolerance = 1e-4;  // m and rad

double distance(const ScanPoint& a, const ScanPoint& b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

void Hough::Options::declare(OptionVisitor& visit) {
  visit("neighbourhood", neighbourhood, "of a reading: where the line that it votes for is from",
        {.unit = "m", .minimum = 0});
  visit("bandwidth", bandwidth, "of the mean shift, in standard deviations of a vote",
        {.minimum = 0});
  visit("roughness", roughness, "of surfaces, beside the noise: standard deviation",
        {.unit = "m", .minimum = 0});
  visit("spacing", spacing, "readings nearer to the last one that voted do not vote",
        {.unit = "m", .minimum = 0});
}

void Hough::vote(std::span<const ScanPoint> points) {
  votes_.clear();
  std::size_t begin = 0;
  std::size_t end = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!votes_.empty() && distance(points[votes_.back().reading], points[i]) < options_.spacing)
      continue;
    const double reach = options_.neighbourhood / 2;
    end = std::max(end, i);
    while (begin < i && distance(points[begin], points[i]) > reach) ++begin;
    while (end < points.size() && distance(points[end], points[i]) <= reach) ++end;
    constexpr std::size_t half = least_neighbours / 2;
    const ReadingRun run{std::min(begin, i - std::min(i, half)),
                         std::min(std::max(end, i + half + 1), points.size())};
    if (run.size() < 3) continue;
    const LeastSquaresLine line = fits_.line(run);
    const double variance =
        std::max(1e-12, line.variance + options_.roughness * options_.roughness);
    const auto count = static_cast<double>(run.size());
    const double chord = distance(points[run.begin], points[run.end - 1]);
    // Readings at even steps of a chord L have the scatter n L² / 12 along it.
    votes_.push_back({{line.centre_x, line.centre_y, line.normal_x, line.normal_y},
                      count / variance,
                      count * chord * chord / (12 * variance),
                      line.square / ((count - 2) * variance),
                      i,
                      0});
  }
}

Hough::Difference Hough::difference(const Place& line, const Vote& vote) const {
  const double x = vote.place.x - line.x;
  const double y = vote.place.y - line.y;
  const double along = line.normal_x * y - line.normal_y * x;
  const double offset = line.normal_x * x + line.normal_y * y;
  const double cross = line.normal_x * vote.place.normal_y - line.normal_y * vote.place.normal_x;
  const double dot = line.normal_x * vote.place.normal_x + line.normal_y * vote.place.normal_y;
  const double angle = dot < 0 ? -cross : cross;  // a line has two normals
  const double square = (offset * offset * vote.offset_weight + angle * angle * vote.angle_weight) /
                        (options_.bandwidth * options_.bandwidth);
  return {along, offset, angle, std::abs(dot) < least_cosine ? INFINITY : square};
}

Hough::Place Hough::shifted(Place line, std::span<const Vote> votes) const {
  for (int k = 0; k < most_shifts; ++k) {
    // Normal equations of the turn and the offset that bring the line to the votes' mean.
    double aa = 0;
    double ar = 0;
    double rr = 0;
    double a = 0;
    double r = 0;
    for (const Vote& vote : votes) {
      const Difference seen = difference(line, vote);
      if (seen.square >= 1) continue;
      aa += vote.offset_weight * seen.along * seen.along + vote.angle_weight;
      ar -= vote.offset_weight * seen.along;
      rr += vote.offset_weight;
      a += vote.angle_weight * seen.angle - vote.offset_weight * seen.along * seen.offset;
      r += vote.offset_weight * seen.offset;
    }
    const double determinant = aa * rr - ar * ar;
    if (!(determinant > 0)) return line;
    const double turn = (rr * a - ar * r) / determinant;
    const double offset = (aa * r - ar * a) / determinant;
    const double normal_x = line.normal_x - turn * line.normal_y;
    const double normal_y = line.normal_y + turn * line.normal_x;
    const double norm = std::hypot(normal_x, normal_y);
    line = {line.x + offset * line.normal_x, line.y + offset * line.normal_y, normal_x / norm,
            normal_y / norm};
    if (std::abs(turn) < shift_tolerance && std::abs(offset) < shift_tolerance) return line;
  }
  return line;
}

void Hough::cluster() {
  order_.resize(votes_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return votes_[a].misfit != votes_[b].misfit ? votes_[a].misfit < votes_[b].misfit : a < b;
  });
  std::size_t line = 0;
  for (const std::size_t start : order_) {
    if (votes_[start].line != 0) continue;
    const std::size_t begin = start - std::min(start, cluster_reach);
    const std::size_t end = std::min(start + cluster_reach, votes_.size());
    const std::span<Vote> votes = std::span<Vote>(votes_).subspan(begin, end - begin);
    const Place place = shifted(votes_[start].place, votes);
    votes_[start].line = ++line;
    const auto votes_for_line = [&](const Vote& vote) {
      return vote.line == 0 && difference(place, vote).square < 1;
    };
    for (Vote& vote : votes)
      if (votes_for_line(vote)) vote.line = line;
    // A longer line goes on as far as votes for it do.
    for (std::size_t k = end; k < votes_.size() && votes_for_line(votes_[k]); ++k)
      votes_[k].line = line;
    for (std::size_t k = begin; k-- > 0 && votes_for_line(votes_[k]);) votes_[k].line = line;
  }
}

void Hough::find_runs(std::span<const ScanPoint> points) {
  runs_.clear();
  lines_.clear();
  for (std::size_t k = 0; k < votes_.size();) {
    const std::size_t line = votes_[k].line;
    const std::size_t begin = votes_[k].reading;
    while (k < votes_.size() && votes_[k].line == line) ++k;
    const std::size_t end = votes_[k - 1].reading + 1;
    const bool is_short = end - begin < least_neighbours ||
                          distance(points[begin], points[end - 1]) < options_.neighbourhood / 2;
    if (is_short) continue;
    if (!runs_.empty() && lines_.back() == line) {
      runs_.back().end = end;
      continue;
    }
    runs_.push_back({begin, end});
    lines_.push_back(line);
  }
}

void Hough::append_runs(std::size_t count, std::vector<ReadingRun>& runs) const {
  if (runs_.empty()) {
    runs.push_back({0, count});
    return;
  }
  const std::size_t first = runs.size();
  runs.insert(runs.end(), runs_.begin(), runs_.end());
  runs[first].begin = 0;
  runs.back().end = count;
  const auto cost = [&](const ReadingRun& run) { return fits_.line(run).square; };
  for (std::size_t k = first; k + 1 < runs.size(); ++k) {
    const std::size_t gap = runs[k + 1].begin - runs[k].end;
    runs[k].end = runs[k + 1].begin = runs[k].end + gap / 2;
    runs[k].end = runs[k + 1].begin =
        placed_boundary(runs[k], runs[k + 1], gap / 2 + boundary_reach, cost, cost);
  }
}

void Hough::segment(std::span<const ScanPoint> points, const LaserNoise& noise,
                    std::vector<ReadingRun>& runs) {
  fits_.update(points, noise);
  vote(points);
  cluster();
  find_runs(points);
  append_runs(points.size(), runs);
}

}  // namespace ilss
