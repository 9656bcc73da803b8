// A tick as people read it: a line an output, with a mark where its error is not to be believed.
#pragma once

#include <array>
#include <string>

#include "framework/runtime/characteristic_output.h"

namespace ilss {

/// How often there was which verdict.
using VerdictCounts = std::array<std::uint64_t, static_cast<std::size_t>(Verdict::invalid) + 1>;

/// The verdicts that are not linear_ok: "23 second_order, 2 invalid"; empty where there is none.
std::string verdict_counts_text(const VerdictCounts& counts);

/// Outputs up to this number are shown one by one at every tick; more are counted.
inline constexpr std::size_t most_outputs_shown = 4;

/// What one output came to, on one line: "x 930.0 ± 1.2 mm  ~ second_order", the module and message
/// of a fault, or "pending".
std::string output_text(const CharacteristicOutput& output);

/// The commands given before a tick, then its number, time and outputs; the elements of sets below
/// them. Lines that end.
std::string tick_text(const TickView& tick);

}  // namespace ilss
