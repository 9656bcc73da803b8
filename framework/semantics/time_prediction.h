// How late an answer will be: module times composed over the plan.
#pragma once

#include <string>
#include <vector>

#include "framework/graph/plan.h"

namespace ilss {

/// Whether branches of a combine run side by side.
enum class Execution { one_thread, parallel };

/// End-to-end compute time of a plan (s). A module that several branches share counts once:
/// in one thread times add up, in parallel the longest path counts
/// (Henderson & Dekhil 1997, sec. 2.2: serial sums, combine takes the maximum).
struct TimePrediction {
  double typical = 0;
  double worst = 0;
  std::vector<std::size_t> critical_path;  ///< nodes, by worst time; every node in one thread
  std::vector<std::size_t> unknown;        ///< nodes of no declared or profiled time, taken as 0
};

TimePrediction predict_time(const Plan& plan, Execution execution);

}  // namespace ilss
