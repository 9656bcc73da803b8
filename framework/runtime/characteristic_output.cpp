#include "framework/runtime/characteristic_output.h"

namespace ilss {

std::string_view outcome_name(const Outcome<>& outcome) {
  if (outcome.has_output()) return "output";
  return outcome.is_pending() ? "pending" : "fault";
}

CharacteristicOutput TickView::view(std::size_t node, const VerdictReport* verdict) const {
  const NodeState& state = system_->node(node);
  const Output* latest = state.has_value ? &state.output() : nullptr;
  Duration compute_time{};
  if (!beside_.counts.empty())
    compute_time = Duration(
        static_cast<Duration::rep>(CycleClock::instance().nanoseconds(0, beside_.counts[node])));
  return {.tick = tick(),
          .time = time(),
          .node = node,
          .module = plan().nodes[node],
          .outcome = state.outcome,
          .origin = state.outcome.is_fault() ? &plan().nodes[state.origin.value_or(node)] : nullptr,
          .output = state.outcome.has_output() ? latest : nullptr,
          .latest = latest,
          .compute_time = compute_time,
          .verdict = state.outcome.has_output() ? verdict : nullptr};
}

const VerdictReport* TickView::verdict_on(std::size_t node) const {
  const auto [first, count] = judged();
  for (std::size_t o = first; o < first + count; ++o)
    if (plan().outputs[o] == node) return verdict_on_output(o);
  return nullptr;
}

CharacteristicOutput TickView::deciding_output() const {
  std::size_t deciding = 0;
  for (std::size_t o = 0; o < outputs(); ++o) {
    const Outcome<>& outcome = system_->node(plan().outputs[o]).outcome;
    if (outcome.is_fault()) return output(o);
    if (outcome.is_pending()) deciding = o;
  }
  return output(deciding);
}

}  // namespace ilss
