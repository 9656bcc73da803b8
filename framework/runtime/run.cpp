#include "framework/runtime/run.h"

#include <fmt/format.h>

#include <algorithm>

namespace ilss {

namespace {

/// A moment and what comes after it, but no later than the last moment there is.
Time later(Time time, Duration wait) {
  Duration::rep sum = 0;
  return __builtin_add_overflow(time.time_since_epoch().count(), wait.count(), &sum)
             ? Time::max()
             : Time(Duration(sum));
}

}  // namespace

std::string_view run_end_name(RunEnd end) {
  switch (end) {
    case RunEnd::end_of_data:
      return "end_of_data";
    case RunEnd::device_lost:
      return "device_lost";
    case RunEnd::most_ticks:
      return "most_ticks";
    case RunEnd::interrupted:
      return "interrupted";
  }
  return "";
}

Run::Run(const Plan& plan, RunOptions options)
    : plan_(plan),
      options_(std::move(options)),
      runner_(plan, options_.seed,
              {.folding = options_.folding,
               .stand_ins = std::move(options_.stand_ins),
               .follow_data = options_.pacing == Pacing::data},
              options_.threads),
      pacer_(options_.pacing, options_.period, options_.interrupted) {}

bool Run::open(Diagnostics& diagnostics) {
  const std::size_t known = diagnostics.size();
  for (const OpenFault& open : system().open())
    diagnostics.add(plan_.nodes[open.node].position,
                    fmt::format("'{}': {}", plan_.nodes[open.node].name, open.fault.message));
  if (diagnostics.size() == known && options_.pacing == Pacing::data && !system().next_data_time())
    diagnostics.add({}, fmt::format("'{}' cannot follow its data: no module has data with times of "
                                    "their own",
                                    plan_.name));
  return diagnostics.size() == known;
}

void Run::schedule(ScheduledCommand command) {
  if (first_) {
    command.time = later(*first_, command.time.time_since_epoch());
    runner_.schedule(std::move(command));
  } else {
    options_.commands.push_back(std::move(command));
  }
}

/// The first tick has its time: now it is known when commands are due.
void Run::start_at(Time time) {
  first_ = time;
  for (ScheduledCommand& command : options_.commands) schedule(std::move(command));
  options_.commands.clear();
}

bool Run::step() {
  if (ending_) return false;
  if (options_.most_ticks != 0 && ticks_ == options_.most_ticks) return end(RunEnd::most_ticks);
  if (pacer_.is_interrupted()) return end(RunEnd::interrupted);
  const std::optional<Time> time = pacer_.next(system());
  if (!time) return end(pacer_.is_interrupted() ? RunEnd::interrupted : RunEnd::end_of_data);
  if (!first_) start_at(*time);
  runner_.step(*time);
  const TickView::Beside beside{
      .counts = runner_.counts(),
      .compute_time = Duration(static_cast<Duration::rep>(runner_.compute_ns())),
      .commands = runner_.commander().given()};
  view_.emplace(system(), beside);
  if (ends_with(FaultKind::end_of_data, RunEnd::end_of_data)) return false;
  ++ticks_;
  if (const OutputRange wanted = wanted_verdicts(); wanted.count != 0)
    view_.emplace(system(), TickView::Beside{beside.counts, beside.compute_time, judge(wanted),
                                             wanted.first, beside.commands});
  for (Observer* observer : observers_) observer->observe(*view_);
  ends_with(FaultKind::device_lost, RunEnd::device_lost);
  return true;
}

const Ending& Run::finish() {
  while (step()) {
  }
  return *ending_;
}

/// The outputs that are to be judged in this tick, and those between them.
OutputRange Run::wanted_verdicts() const {
  const std::size_t outputs = plan_.outputs.size();
  if (options_.judge_every) {
    const std::int64_t every = *options_.judge_every;
    return {0, every != 0 && (ticks_ - 1) % every == 0 ? outputs : 0};
  }
  std::size_t first = outputs;
  std::size_t end = 0;
  for (Observer* observer : observers_) {
    const OutputRange wanted = observer->wants_verdicts(*view_);
    if (wanted.count == 0) continue;
    first = std::min(first, wanted.first);
    end = std::max(end, wanted.first + wanted.count);
  }
  return first < end ? OutputRange{first, end - first} : OutputRange{};
}

std::span<const VerdictReport> Run::judge(OutputRange outputs) {
  if (!judge_ || judged_ != outputs) {
    const auto first = plan_.outputs.begin() + static_cast<std::ptrdiff_t>(outputs.first);
    judge_.reset();
    judge_.emplace(system(), std::vector<std::size_t>(
                                 first, first + static_cast<std::ptrdiff_t>(outputs.count)));
    judged_ = outputs;
  }
  ++judged_ticks_;
  verdicts_ += static_cast<std::int64_t>(outputs.count);
  return judge_->judge();
}

/// Ends the run where a module has such a fault; one in a branch is for its selector to see.
bool Run::ends_with(FaultKind kind, RunEnd reason) {
  if (!runner_.has_fault()) return false;
  for (std::size_t i = 0; i < view_->size(); ++i) {
    if (!system().regions().is_always(i)) continue;
    const CharacteristicOutput output = (*view_)[i];
    if (!output.outcome.is_fault() || output.outcome.fault().kind != kind) continue;
    ending_ = Ending{reason, output.origin, output.outcome.fault()};
    return true;
  }
  return false;
}

}  // namespace ilss
