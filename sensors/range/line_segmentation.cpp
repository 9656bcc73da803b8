#include "sensors/range/line_segmentation.h"

#include <algorithm>

namespace ilss {
namespace {

/// How far the recursive test looks back, at least and at most.
constexpr std::size_t shortest_window = 4;
constexpr std::size_t longest_window = 64;
constexpr int most_rounds = 8;
/// Below it a saving in cost is rounding.
constexpr double least_saving = 1e-6;

}  // namespace

void LineSegmentation::clear() {
  runs_.assign(1, {});
  gaps_.clear();
}

double LineSegmentation::cost(const LineInformationSums& sums, std::size_t begin,
                              std::size_t end) const {
  if (begin == end) return 0;
  const double cost_as_outliers = rule_.outlier_cost * static_cast<double>(end - begin);
  if (end - begin < rule_.least_readings) return cost_as_outliers;
  return std::min(cost_as_outliers, sums.of(begin, end).chi_squared() + rule_.evidence);
}

LineSegmentation::Split LineSegmentation::best_split(const LineInformationSums& sums,
                                                     std::size_t begin, std::size_t end) const {
  Split best{end, cost(sums, begin, end)};
  for (std::size_t at = begin + 1; at < end; ++at)
    if (const double c = cost(sums, begin, at) + cost(sums, at, end); c < best.cost) best = {at, c};
  return best;
}

bool LineSegmentation::advance(const LineInformationSums& sums) {
  ReadingRun& open = runs_.back();
  open.end = sums.size();
  const std::size_t size = open.size();
  if (size < 2 * shortest_window) return false;
  double whole = -1;
  for (std::size_t window = shortest_window; window <= longest_window; window *= 2) {
    // A longer look back moves slowly, and need not be taken at every reading.
    if (size < window + shortest_window || size % (window / shortest_window) != 0) break;
    if (whole < 0) whole = sums.of(open.begin, open.end).chi_squared();
    if (whole < rule_.evidence) return false;
    const std::size_t at = open.end - window;
    const double parts =
        sums.of(open.begin, at).chi_squared() + sums.of(at, open.end).chi_squared();
    if (whole - parts < rule_.evidence) continue;
    const Split split = best_split(sums, open.begin, open.end);
    if (split.at == open.end) continue;
    const std::size_t end = open.end;
    open.end = split.at;
    runs_.push_back({split.at, end});
    return true;
  }
  return false;
}

void LineSegmentation::break_before_last(const LineInformationSums& sums) {
  const std::size_t last = sums.size() - 1;
  runs_.back().end = last;
  if (runs_.back().size() == 0) runs_.pop_back();
  runs_.push_back({last, last + 1});
  gaps_.push_back(last);
}

bool LineSegmentation::is_behind_gap(std::size_t begin) const {
  return std::binary_search(gaps_.begin(), gaps_.end(), begin);
}

/// One pass over the runs: each is split where that is worth it, and the end that it shares with
/// the next moves to the best place, which may be either's other end: then the two are one.
bool LineSegmentation::refine_once(const LineInformationSums& sums) {
  bool changed = false;
  refined_.clear();
  for (const ReadingRun& run : runs_) {
    ReadingRun rest = run;
    if (!refined_.empty() && !is_behind_gap(rest.begin)) {
      ReadingRun& before = refined_.back();
      const Split split = best_split(sums, before.begin, rest.end);
      const double now = cost(sums, before.begin, before.end) + cost(sums, rest.begin, rest.end);
      if (split.cost < now - least_saving) {
        changed = true;
        before.end = split.at;
        rest.begin = split.at;
        if (rest.size() == 0) continue;
      }
    }
    refined_.push_back(rest);
  }
  runs_.swap(refined_);
  refined_.clear();
  for (const ReadingRun& run : runs_) {
    const Split split = best_split(sums, run.begin, run.end);
    if (split.at < run.end) {
      changed = true;
      refined_.push_back({run.begin, split.at});
      refined_.push_back({split.at, run.end});
    } else {
      refined_.push_back(run);
    }
  }
  runs_.swap(refined_);
  return remove_middles(sums) || changed;
}

/// Takes out runs that neither neighbour alone would take, but both together do.
bool LineSegmentation::remove_middles(const LineInformationSums& sums) {
  bool changed = false;
  for (std::size_t i = 1; i + 1 < runs_.size();) {
    const std::size_t begin = runs_[i - 1].begin;
    const std::size_t end = runs_[i + 1].end;
    if (is_behind_gap(runs_[i].begin) || is_behind_gap(runs_[i + 1].begin)) {
      ++i;
      continue;
    }
    double now = 0;
    for (std::size_t k = i - 1; k <= i + 1; ++k) now += cost(sums, runs_[k].begin, runs_[k].end);
    const Split split = best_split(sums, begin, end);
    if (split.cost >= now - least_saving) {
      ++i;
      continue;
    }
    changed = true;
    runs_[i - 1].end = split.at;
    runs_[i + 1].begin = split.at;
    const std::size_t taken_out = split.at == end ? 2 : 1;
    runs_.erase(runs_.begin() + static_cast<std::ptrdiff_t>(i),
                runs_.begin() + static_cast<std::ptrdiff_t>(i + taken_out));
  }
  return changed;
}

void LineSegmentation::refine(const LineInformationSums& sums) {
  runs_.back().end = sums.size();
  for (int round = 0; round < most_rounds && refine_once(sums); ++round) {
  }
}

}  // namespace ilss
