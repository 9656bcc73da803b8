// Agreement: do outputs that claim to measure the same thing differ by no more than they say?
#pragma once

#include <cstdint>
#include <vector>

#include "framework/runtime/characteristic_output.h"

namespace ilss {

/// How often two outputs agreed.
struct AgreementCount {
  std::size_t first;  ///< index into the plan's outputs
  std::size_t second;
  std::uint64_t compared = 0;  ///< ticks in which both gave an output
  std::uint64_t agreed = 0;    ///< of these, within the 95 % bound of their difference
};

/// Compares neighbouring outputs of one payload in one frame (the last with the first, too, where
/// there are more than two) by their normalised innovation squared; errors that they share cancel.
class Agreement final : public Observer {
 public:
  static constexpr double probability = 0.95;

  explicit Agreement(const Plan& plan);

  /// Compares the tick's outputs.
  void observe(const TickView& tick) override;

  const std::vector<AgreementCount>& pairs() const { return pairs_; }
  /// All pairs together.
  AgreementCount total() const;

 private:
  std::vector<AgreementCount> pairs_;
  std::vector<double> bounds_;  ///< of the normalised innovation squared, by its rank
};

}  // namespace ilss
