// What a run came to: how often each output was there, how wrong it said to be, how long it took.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "framework/report/set_text.h"
#include "framework/report/tick_text.h"
#include "framework/runtime/agreement.h"
#include "framework/runtime/run.h"

namespace ilss {

/// Gathers over the ticks of a run what its summary tells beyond the runner's instruments. No
/// memory is allocated from tick to tick once each output was there.
class RunSummary final : public Observer {
 public:
  /// Of one output.
  struct OfOutput {
    std::uint64_t outputs = 0;
    VerdictCounts verdicts = {};       ///< in the ticks that were judged
    std::vector<double> variance_sum;  ///< of each component
    SetSummary elements = {};          ///< of a set
  };

  /// Where it `samples_verdicts`, it asks for one at the 1st, 2nd, 4th, 8th ... tick, on one output
  /// after another: ever rarer, and of wide systems no more than of narrow ones, so that verdicts
  /// do not decide what a run costs.
  RunSummary(const Plan& plan, bool samples_verdicts);

  OutputRange wants_verdicts(const TickView& tick) override;
  void observe(const TickView& tick) override;

  const std::vector<OfOutput>& outputs() const { return outputs_; }
  const Agreement& agreement() const { return agreement_; }

 private:
  bool samples_verdicts_;
  std::size_t next_sampled_ = 0;  ///< output
  std::vector<OfOutput> outputs_;
  Agreement agreement_;
};

/// How many ticks there were, then outputs, agreement between them, and compute times, as tables.
std::string summary_text(const Run& run, const RunSummary& summary);

}  // namespace ilss
