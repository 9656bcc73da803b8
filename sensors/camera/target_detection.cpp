#include "sensors/camera/target_detection.h"

#include <algorithm>
#include <cmath>

#include "framework/estimate/random.h"

namespace ilss {
namespace {

Fault no_detection(const char* message) { return {FaultKind::no_detection, message}; }

/// The level between a dark and a bright class that makes the classes' means differ most (Otsu
/// 1979), and those means.
struct Threshold {
  double level;
  double dark;
  double bright;
};
Threshold find_threshold(const ImageView& view) {
  std::array<double, 256> histogram{};
  for (int along = 0; along < view.along_size; ++along)
    for (int across = 0; across < view.across_size; ++across)
      ++histogram[static_cast<std::size_t>(view.at(along, across))];
  double total = 0;
  double sum = 0;
  for (std::size_t level = 0; level < 256; ++level) {
    total += histogram[level];
    sum += static_cast<double>(level) * histogram[level];
  }
  Threshold best{0, 0, 0};
  double best_separation = 0;
  double dark_count = 0;
  double dark_sum = 0;
  for (std::size_t level = 0; level < 255; ++level) {
    dark_count += histogram[level];
    dark_sum += static_cast<double>(level) * histogram[level];
    const double bright_count = total - dark_count;
    if (dark_count == 0 || bright_count == 0) continue;
    const double dark = dark_sum / dark_count;
    const double bright = (sum - dark_sum) / bright_count;
    const double separation = dark_count * bright_count * (bright - dark) * (bright - dark);
    if (separation <= best_separation) continue;
    best_separation = separation;
    best = {0.5 * (dark + bright), dark, bright};
  }
  return best;
}

/// A run of dark pixels down a column.
struct Run {
  int column;
  double length;
  double centre;             ///< row in the image
  ImagePoint<double> ideal;  ///< the centre without lens distortion
};

/// Runs that a line could leave: neither cut off by the border nor longer than a third of the
/// image.
std::vector<Run> find_runs(const ImageView& view, const Image<double>& camera, double threshold) {
  std::vector<Run> runs;
  const bool distorted = is_distorted(camera);
  for (int column = 0; column < view.along_size; ++column) {
    int begin = -1;
    for (int row = 0; row < view.across_size; ++row) {
      const bool dark = view.at(column, row) < threshold;
      if (dark && begin < 0) begin = row;
      if (dark || begin < 0) continue;
      const double length = row - begin;
      const double centre = 0.5 * (row + begin - 1);
      if (begin > 0 && 3 * (row - begin) <= view.across_size) {
        const ImagePoint<double> shown{static_cast<double>(column), centre};
        const auto ideal = distorted ? undistort_pixel(camera, shown) : shown;
        if (ideal) runs.push_back({column, length, centre, *ideal});
      }
      begin = -1;
    }
  }
  return runs;
}

double row_distance(const StraightEdge& line, const Run& run) {
  return run.ideal.row - (line.offset + line.slope * (run.ideal.column - line.reference));
}

constexpr double run_tolerance = 1;
std::vector<const Run*> runs_near(const std::vector<Run>& runs, const StraightEdge& line) {
  std::vector<const Run*> result;
  for (const Run& run : runs)
    if (std::abs(row_distance(line, run)) < run_tolerance) result.push_back(&run);
  return result;
}

/// The straight line through most runs' centres (random pairs of them, consensus within a pixel).
struct LineCandidate {
  StraightEdge line{};
  std::vector<const Run*> runs = {};
};
LineCandidate find_line(const std::vector<Run>& runs, const ImageView& view) {
  constexpr int most_trials = 400;
  constexpr double steepest = 1;
  RandomBits random(1);
  StraightEdge best{0, 0, std::floor(0.5 * view.along_size), false};
  int most = 0;
  for (int trial = 0; trial < most_trials; ++trial) {
    const Run& p = runs[draw_index(random, runs.size())];
    const Run& q = runs[draw_index(random, runs.size())];
    const double width = q.ideal.column - p.ideal.column;
    if (4 * std::abs(width) < view.along_size) continue;
    StraightEdge line = best;
    line.slope = (q.ideal.row - p.ideal.row) / width;
    if (std::abs(line.slope) > steepest) continue;
    line.offset = p.ideal.row + line.slope * (line.reference - p.ideal.column);
    const int count = static_cast<int>(std::count_if(runs.begin(), runs.end(), [&](const Run& run) {
      return std::abs(row_distance(line, run)) < run_tolerance;
    }));
    if (count <= most) continue;
    most = count;
    best = line;
    if (10 * most > 9 * view.along_size) break;
  }
  return {best, runs_near(runs, best)};
}

/// Refines a candidate: keeps runs of its usual length, which leaves out where stripes cross, and
/// fits the line to them by least squares. Returns that length.
double refine_line(LineCandidate& candidate) {
  std::vector<double> lengths;
  for (const Run* run : candidate.runs) lengths.push_back(run->length);
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  const double thickness = *middle;
  std::erase_if(candidate.runs, [&](const Run* run) {
    return std::abs(run->length - thickness) > 1 + 0.3 * thickness;
  });
  double n = 0;
  double sum_x = 0;
  double sum_y = 0;
  double sum_xx = 0;
  double sum_xy = 0;
  for (const Run* run : candidate.runs) {
    const double x = run->ideal.column - candidate.line.reference;
    const double y = run->ideal.row;
    n += 1;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const double determinant = n * sum_xx - sum_x * sum_x;
  if (determinant > 0) {
    candidate.line.slope = (n * sum_xy - sum_x * sum_y) / determinant;
    candidate.line.offset = (sum_y - candidate.line.slope * sum_x) / n;
  }
  return thickness;
}

/// What lies beside the line at a column.
enum class Beside { bright, dark, other };

/// Looks past the line's edges, above and below.
class Surroundings {
 public:
  Surroundings(const ImageView& view, const Image<double>& camera, const Threshold& threshold,
               const StraightEdge& line, double thickness)
      : view_(view), threshold_(threshold), thickness_(thickness) {
    rows_.reserve(static_cast<std::size_t>(view.along_size));
    for (int column = 0; column < view.along_size; ++column) {
      const auto at = edge_at(camera, line, column);
      rows_.push_back(at ? at->across : -1e6);
    }
  }
  double row(int column) const { return rows_[static_cast<std::size_t>(column)]; }

  Beside at(int column) const {
    constexpr double gap = 1.5;
    const int depth = std::max(3, static_cast<int>(std::lround(thickness_)));
    const double top = row(column) - 0.5 * thickness_ - gap;
    const double bottom = row(column) + 0.5 * thickness_ + gap;
    const int above_end = static_cast<int>(std::floor(top)) + 1;
    const int below_begin = static_cast<int>(std::ceil(bottom));
    if (above_end - depth < 0 || below_begin + depth > view_.across_size) return Beside::other;
    const double above = mean(column, above_end - depth, above_end);
    const double below = mean(column, below_begin, below_begin + depth);
    if (above < threshold_.level && below < threshold_.level) return Beside::dark;
    const double bright = 0.5 * (threshold_.level + threshold_.bright);
    return above > bright && below > bright ? Beside::bright : Beside::other;
  }

 private:
  double mean(int column, int begin, int end) const {
    double sum = 0;
    for (int row = begin; row < end; ++row) sum += view_.at(column, row);
    return sum / (end - begin);
  }

  const ImageView& view_;
  const Threshold& threshold_;
  double thickness_;
  std::vector<double> rows_;
};

/// How far around a band of some width its background is looked at.
int margin_of(double width) { return std::clamp(static_cast<int>(std::lround(width)), 3, 8); }

/// The line's windows: columns where it was found, two away from anything else than bright wall.
std::vector<BandWindow> line_windows(const LineCandidate& line, const ImageView& view,
                                     const std::vector<Beside>& beside,
                                     const Surroundings& surroundings, double thickness) {
  constexpr int clearance = 2;
  const int columns = view.along_size;
  std::vector<char> usable(static_cast<std::size_t>(columns), 0);
  for (const Run* run : line.runs) usable[static_cast<std::size_t>(run->column)] = 1;
  for (int j = 0; j < columns; ++j)
    if (beside[static_cast<std::size_t>(j)] != Beside::bright)
      usable[static_cast<std::size_t>(j)] = 0;
  std::vector<BandWindow> windows;
  for (int j = 0; j < columns; ++j) {
    bool clear = true;
    for (int k = std::max(0, j - clearance); k <= std::min(columns - 1, j + clearance); ++k)
      clear = clear && usable[static_cast<std::size_t>(k)] != 0;
    if (!clear) continue;
    const int margin = margin_of(thickness);
    const double half = 0.5 * thickness;
    const int begin = static_cast<int>(std::floor(surroundings.row(j) - half)) - margin;
    const int end = static_cast<int>(std::ceil(surroundings.row(j) + half)) + margin + 1;
    windows.push_back({j, std::max(begin, 0), std::min(end, view.across_size)});
  }
  return windows;
}

/// Columns [begin, end) that are dark above and below the line.
struct DarkColumns {
  int begin;
  int end;
};
std::vector<DarkColumns> dark_columns(const std::vector<Beside>& beside) {
  std::vector<DarkColumns> result;
  const int columns = static_cast<int>(beside.size());
  for (int j = 0; j < columns; ++j) {
    if (beside[static_cast<std::size_t>(j)] != Beside::dark) continue;
    const int begin = j;
    while (j < columns && beside[static_cast<std::size_t>(j)] == Beside::dark) ++j;
    if (4 * (j - begin) <= columns) result.push_back({begin, j});
  }
  return result;
}

/// A stripe's rows up or down from the line (`direction` -1 or 1) as far as it stays dark, less
/// two at its end.
void add_stripe_windows(const ImageView& view, const Image<double>& camera,
                        const StraightEdge& middle, double half_width, int margin, int row,
                        int direction, double threshold, std::vector<BandWindow>& windows) {
  constexpr std::size_t end_clearance = 2;
  const std::size_t before = windows.size();
  for (; row >= 0 && row < view.across_size; row += direction) {
    const auto at = edge_at(camera, middle, row);
    if (!at) break;
    const int begin = static_cast<int>(std::floor(at->across - half_width)) - margin;
    const int end = static_cast<int>(std::ceil(at->across + half_width)) + margin + 1;
    const int centre = static_cast<int>(std::lround(at->across));
    if (begin < 0 || end > view.along_size || view.at(centre, row) >= threshold) break;
    windows.push_back({row, begin, end});
  }
  windows.resize(std::max(before, windows.size() - std::min(windows.size(), end_clearance)));
}

/// The stripe at the given columns; too few rows or columns around it leave it without windows.
DetectedBand make_stripe(const ImageView& view, const Image<double>& camera,
                         const Threshold& threshold, const Surroundings& surroundings,
                         double thickness, double line_slope, const DarkColumns& dark,
                         int free_columns) {
  DetectedBand stripe{};
  const double left = dark.begin - 0.5;
  const double right = dark.end - 0.5;
  const int middle_column = (dark.begin + dark.end) / 2;
  const double row = surroundings.row(std::min(middle_column, view.along_size - 1));
  const auto ideal = undistort_pixel(camera, ImagePoint<double>{0.5 * (left + right), row});
  if (!ideal) return stripe;
  const double half_width = 0.5 * (right - left);
  const StraightEdge middle{ideal->column, 0, std::round(ideal->row), true};
  stripe.edges = {middle, middle};
  stripe.edges[0].offset -= half_width;
  stripe.edges[1].offset += half_width;

  constexpr int least_margin = 2;
  const int margin = std::min(margin_of(right - left), free_columns);
  if (margin < least_margin) return stripe;
  const double clearance = 0.5 * thickness + 2 + std::abs(line_slope) * (half_width + margin);
  add_stripe_windows(view, camera, middle, half_width, margin,
                     static_cast<int>(std::floor(row - clearance)), -1, threshold.level,
                     stripe.windows);
  add_stripe_windows(view, camera, middle, half_width, margin,
                     static_cast<int>(std::ceil(row + clearance)), 1, threshold.level,
                     stripe.windows);
  constexpr std::size_t least_rows = 4;
  if (stripe.windows.size() < least_rows) stripe.windows.clear();
  return stripe;
}

}  // namespace

Outcome<DetectedTarget> detect_target(const ImageView& view, const Image<double>& camera) {
  constexpr double least_contrast = 10;
  constexpr std::size_t least_columns = 10;
  const Threshold threshold = find_threshold(view);
  if (threshold.bright - threshold.dark < least_contrast)
    return no_detection("the image has no contrast");
  const std::vector<Run> runs = find_runs(view, camera, threshold.level);
  const auto columns = static_cast<std::size_t>(view.along_size);
  if (runs.size() < least_columns) return no_detection("the image shows no dark line");
  if (runs.size() > 8 * columns) return no_detection("the image is too cluttered to find a line");

  LineCandidate line = find_line(runs, view);
  if (line.runs.size() < std::max(least_columns, columns / 5))
    return no_detection("the image shows no dark, nearly horizontal line");
  refine_line(line);
  line.runs = runs_near(runs, line.line);  // a line through two runs may have missed the farthest
  const double thickness = refine_line(line);
  const Surroundings surroundings(view, camera, threshold, line.line, thickness);
  std::vector<Beside> beside;
  beside.reserve(columns);
  for (int j = 0; j < view.along_size; ++j) beside.push_back(surroundings.at(j));

  DetectedTarget target;
  target.line.edges = {line.line, line.line};
  target.line.edges[0].offset -= 0.5 * thickness;
  target.line.edges[1].offset += 0.5 * thickness;
  target.line.windows = line_windows(line, view, beside, surroundings, thickness);
  if (target.line.windows.size() < least_columns)
    return no_detection("too little of the line stands free of other dark things");

  const std::vector<DarkColumns> dark = dark_columns(beside);
  for (std::size_t i = 0; i < dark.size(); ++i) {
    int free_columns = std::min(dark[i].begin, view.along_size - dark[i].end) - 1;
    if (i > 0) free_columns = std::min(free_columns, (dark[i].begin - dark[i - 1].end) / 2);
    if (i + 1 < dark.size())
      free_columns = std::min(free_columns, (dark[i + 1].begin - dark[i].end) / 2);
    DetectedBand stripe = make_stripe(view, camera, threshold, surroundings, thickness,
                                      line.line.slope, dark[i], free_columns);
    if (!stripe.windows.empty()) target.stripes.push_back(std::move(stripe));
  }
  return target;
}

}  // namespace ilss
