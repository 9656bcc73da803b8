#include "framework/report/run_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "framework/report/estimate_text.h"

namespace ilss {
namespace {

/// So many modules have a row of their own among the compute times.
constexpr std::size_t most_rows = 60;

std::string ticks_text(const Run& run) {
  std::string text = fmt::format("{} tick{}", run.ticks(), run.ticks() == 1 ? "" : "s");
  if (run.ending() && run.ending()->reason == RunEnd::end_of_data)
    text += ", to the end of the data";
  if (run.judged_ticks() == 0)
    text += "; no verdicts";
  else if (run.verdicts() <
           run.judged_ticks() * static_cast<std::int64_t>(run.plan().outputs.size()))
    text += fmt::format("; {} verdict{}, on {} of them", run.verdicts(),
                        run.verdicts() == 1 ? "" : "s", run.judged_ticks());
  else if (run.judged_ticks() < run.ticks())
    text += fmt::format("; verdicts on {} of them", run.judged_ticks());
  if (run.missed_periods() != 0)
    text += fmt::format("; {} period{} missed", run.missed_periods(),
                        run.missed_periods() == 1 ? "" : "s");
  return text + "\n";
}

/// Faults by kind; the end of the data is how runs end, not a fault to count.
std::string fault_counts_text(const OutcomeCounts& counts) {
  std::string text;
  for (std::size_t kind = 0; kind < OutcomeCounts::fault_kinds; ++kind)
    if (counts.faults_by_kind[kind] != 0 && static_cast<FaultKind>(kind) != FaultKind::end_of_data)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts.faults_by_kind[kind],
                          fault_name(static_cast<FaultKind>(kind)));
  if (counts.pending != 0)
    text += fmt::format("{}{} pending", text.empty() ? "" : ", ", counts.pending);
  return text.empty() ? "-" : text;
}

/// "x 1.2 mm, phi 0.3 deg": root mean squares; of samples and sets, what is exact is left out.
std::string stated_text(const RunSummary::OfOutput& summary, const PayloadDescriptor& payload) {
  std::string stated;
  for (std::size_t i = 0; i < summary.variance_sum.size(); ++i) {
    if (has_parts(payload) && summary.variance_sum[i] <= 0) continue;
    const Component& component = payload.components[i];
    stated += fmt::format(
        "{}{} {}", stated.empty() ? "" : ", ", component.name,
        quantity_text(std::sqrt(summary.variance_sum[i] / static_cast<double>(summary.outputs)),
                      component.unit));
  }
  const std::string not_linear = verdict_counts_text(summary.verdicts);
  if (!not_linear.empty()) stated += fmt::format("   ({})", not_linear);
  return stated.empty() && has_parts(payload) ? "-" : stated;
}

std::string outputs_text(const Run& run, const RunSummary& summary) {
  const Plan& plan = run.plan();
  std::string text = fmt::format("\n{:<20} {:>8}  {:<40} stated std (root mean square)\n", "output",
                                 "outputs", "faults");
  const auto add_row = [&](const std::string& name, std::uint64_t count, const std::string& faults,
                           const std::string& stated) {
    text += fmt::format("{:<20} {:>8}  {:<40} {}\n", name, count, faults, stated);
  };
  for (std::size_t o = 0; o < plan.outputs.size(); ++o) {
    const std::size_t node = plan.outputs[o];
    const RunSummary::OfOutput& output = summary.outputs()[o];
    add_row(plan.nodes[node].name, output.outputs, fault_counts_text(run.runner().outcomes(node)),
            stated_text(output, *plan.nodes[node].interface.output));
    for (const SetSummary::Entry& entry : output.elements.entries())
      add_row("  " + entry.type->name, entry.count, "", summary_text(entry, output.outputs));
  }
  return text;
}

std::string agreement_text(const Agreement& agreement, const Plan& plan) {
  if (agreement.pairs().empty()) return {};
  std::string text =
      fmt::format("\n{:<20} {:<20} {:>9} {:>9}   (difference within its 95 % bound)\n", "output",
                  "and output", "compared", "agree");
  for (const AgreementCount& pair : agreement.pairs())
    if (pair.compared != 0)
      text += fmt::format("{:<20} {:<20} {:>9} {:>9}\n", plan.nodes[plan.outputs[pair.first]].name,
                          plan.nodes[plan.outputs[pair.second]].name, pair.compared, pair.agreed);
  const AgreementCount total = agreement.total();
  if (total.compared != 0)
    text += fmt::format(
        "all: {} of {} agree ({:.1f} %; 95 % would if errors are as stated and both see the "
        "same)\n",
        total.agreed, total.compared,
        100.0 * static_cast<double>(total.agreed) / static_cast<double>(total.compared));
  return text;
}

std::string latency_row(const std::string& name, const LatencySummary& latency) {
  const auto text = [](std::uint64_t ns) { return duration_text(static_cast<double>(ns) * 1e-9); };
  return fmt::format("{:<20} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", name, latency.count,
                     text(latency.p50), text(latency.p90), text(latency.p99), text(latency.p999),
                     text(latency.max));
}

std::string latencies_text(const Runner& runner, const Plan& plan) {
  std::string text = fmt::format("\n{:<20} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "compute time",
                                 "ticks", "p50", "p90", "p99", "p99.9", "max");
  for (std::size_t i = 0; i < std::min(plan.nodes.size(), most_rows); ++i)
    text += latency_row(plan.nodes[i].name, runner.latency(i).summary());
  if (plan.nodes.size() > most_rows)
    text += fmt::format("... and {} more modules\n", plan.nodes.size() - most_rows);
  return text + latency_row("end to end", runner.end_to_end().summary());
}

}  // namespace

RunSummary::RunSummary(const Plan& plan, bool samples_verdicts)
    : samples_verdicts_(samples_verdicts), outputs_(plan.outputs.size()), agreement_(plan) {}

OutputRange RunSummary::wants_verdicts(const TickView& tick) {
  if (!samples_verdicts_ || !std::has_single_bit(static_cast<std::uint64_t>(tick.tick() + 1)))
    return {};
  return {next_sampled_++ % outputs_.size(), 1};
}

void RunSummary::observe(const TickView& tick) {
  agreement_.observe(tick);
  for (std::size_t o = 0; o < outputs_.size(); ++o) {
    const CharacteristicOutput seen = tick.output(o);
    if (seen.output == nullptr) continue;
    OfOutput& summary = outputs_[o];
    ++summary.outputs;
    if (seen.verdict != nullptr)
      ++summary.verdicts[static_cast<std::size_t>(seen.verdict->verdict)];
    const Estimate& estimate = seen.output->estimate;
    summary.variance_sum.resize(estimate.dimension(), 0.0);
    for (std::size_t i = 0; i < summary.variance_sum.size(); ++i)
      summary.variance_sum[i] += estimate.lineage.variance(i);
    if (!estimate.type->element.empty()) summary.elements.add(seen.output->elements);
  }
}

std::string summary_text(const Run& run, const RunSummary& summary) {
  std::string text = "\n" + ticks_text(run);
  if (const std::uint64_t refused = run.runner().commander().refused(); refused != 0)
    text += fmt::format("commands refused: {}\n", refused);
  return text + outputs_text(run, summary) + agreement_text(summary.agreement(), run.plan()) +
         latencies_text(run.runner(), run.plan());
}

}  // namespace ilss
