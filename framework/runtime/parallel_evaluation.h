// One tick by several threads: modules that do not depend on each other side by side.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "framework/graph/system.h"

namespace ilss {

/// Evaluates a system's ticks on oneTBB. A module starts as soon as all that feeds it is done, on
/// the thread that finished the last of that, so a chain costs no hand-off; what a selector
/// evaluates on demand stays on its thread. Since a module's output depends on its inputs and seed
/// alone, the outputs are those of System::evaluate, bit for bit. A hand-off costs about a
/// microsecond: it pays for branches that take longer.
class ParallelEvaluation {
 public:
  /// The system must outlive it. @pre threads > 0
  ParallelEvaluation(System& system, unsigned threads);
  ~ParallelEvaluation();

  /// Evaluates the next tick. `counts` takes what CycleClock counted for each node (0 where it had
  /// no turn); its size is the system's.
  void evaluate(Time time, std::span<std::uint64_t> counts);

 private:
  class Tasks;
  std::unique_ptr<Tasks> tasks_;
};

}  // namespace ilss
