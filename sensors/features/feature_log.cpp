#include "sensors/features/feature_log.h"

#include <fmt/format.h>

#include <algorithm>

#include "sensors/features/range_features.h"

namespace ilss {
namespace {

/// More columns than any element has, so that no two elements share one.
constexpr std::uint32_t columns_of_element = Fields::capacity;

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

/// A first line without what some programs mark UTF-8 with.
std::string_view without_byte_order_mark(std::string_view line) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (line.starts_with(byte_order_mark)) line.remove_prefix(byte_order_mark.size());
  return line;
}

}  // namespace

void FeatureLog::Options::declare(OptionVisitor& visit) {
  visit("file", file, "CSV or JSON of ilss run --features, or what ilss run --json printed",
        {.required = true});
  visit("frame", frame, "name of the frame that the features are in");
  visit("skip_bad", skip_bad, "leave out bad rows (of JSON: lines), instead of a fault");
}

Interface FeatureLog::interface(const Options& options) {
  return {.inputs = {}, .output = &descriptor<RangeFeatures>(), .frame = options.frame};
}

void FeatureLog::reset() {
  next_ = first_;
  last_tick_ = -1;
  any_ = false;
  given_ticks_.clear();
  skipped_ = {};
}

Fault FeatureLog::at_line(std::size_t line, const Fault& fault) const {
  return {fault.kind, fmt::format("{}:{}: {}", options_.file.string(), line + 1, fault.message)};
}

Fault FeatureLog::out_of_order(std::int64_t tick) const {
  return {FaultKind::bad_data, fmt::format("tick {} after tick {}", tick, last_tick_)};
}

/// Empty lines, and comments of CSV.
bool FeatureLog::is_left_out(std::string_view line) const {
  return is_blank(line) || (columns_ && line.front() == '#');
}

Outcome<> FeatureLog::open() {
  if (log_ != nullptr) return {};
  auto opened = TextLog::open(options_.file);
  if (!opened) return opened.fault();
  const TextLog& log = **opened;
  std::size_t line = 0;
  while (line < log.lines() &&
         (is_blank(without_byte_order_mark(log.line(line))) || log.line(line).front() == '#'))
    ++line;
  if (line == log.lines())
    return Fault{FaultKind::device_lost,
                 fmt::format("'{}' has no features", options_.file.string())};
  const std::string_view first = without_byte_order_mark(log.line(line));
  const char start = first[first.find_first_not_of(" \t\r")];
  if (start != '{' && start != '[') {
    auto columns = FeatureColumns::read(first, descriptor<RangeFeatures>());
    if (!columns) return at_line(line, columns.fault());
    columns_ = std::move(*columns);
    ++line;
  }
  first_ = next_ = line;
  log_ = *opened;
  return {};
}

/// The next line of JSON that has a set or is at fault.
Outcome<std::optional<RecordedSet>> FeatureLog::read_line() {
  while (next_ < log_->lines()) {
    const std::size_t line = next_++;
    auto set = parse_feature_json(without_byte_order_mark(log_->line(line)),
                                  descriptor<RangeFeatures>(), options_.frame);
    if (set && !*set) continue;
    if (set && (*set)->time.tick <= last_tick_) set = out_of_order((*set)->time.tick);
    if (set) {
      last_tick_ = (*set)->time.tick;
      return set;
    }
    const Fault fault = at_line(line, set.fault());
    if (!options_.skip_bad) return fault;
    skipped_.add(fault);
  }
  return std::optional<RecordedSet>();
}

/// The next rows of CSV that are one tick's; a row whose tick cannot be read goes with those before
/// it.
Outcome<std::optional<RecordedSet>> FeatureLog::read_rows() {
  RecordedSet set;
  std::optional<std::int64_t> tick;
  std::optional<Fault> fault;
  for (; next_ < log_->lines(); ++next_) {
    const std::string_view line = log_->line(next_);
    if (is_left_out(line)) continue;
    const auto of_row = columns_->tick_of(line);
    const bool is_any = tick || fault || !set.features.empty();
    if (is_any && of_row && of_row != tick) break;
    if (!tick) tick = of_row;
    auto row = columns_->parse(line, options_.frame);
    if (row && row->time.tick <= last_tick_) row = out_of_order(row->time.tick);
    if (!row) {
      if (options_.skip_bad)
        skipped_.add(at_line(next_, row.fault()));
      else if (!fault)
        fault = at_line(next_, row.fault());
      continue;
    }
    set.time = {row->time.tick, std::max(set.time.age, row->time.age)};
    set.features.push_back(std::move((*row).feature));
  }
  if (fault) return *fault;
  if (set.features.empty()) return std::optional<RecordedSet>();
  last_tick_ = set.time.tick;
  return std::optional(std::move(set));
}

/// The recorded source as one of this module's: the same one always, and no other.
Source FeatureLog::source_of(const RecordedSource& recorded) {
  const auto next = static_cast<std::uint32_t>(columns_of_sources_.size());
  const std::uint32_t column =
      columns_of_sources_.try_emplace({recorded.owner, recorded.column}, next).first->second;
  if (recorded.tick == persistent_tick) return {owner_, column, persistent_tick};
  // Of a tick that gave no set itself: before all others.
  constexpr std::int64_t before_the_first = persistent_tick - 1;
  const auto given = given_ticks_.find(recorded.tick);
  return {owner_, column,
          given != given_ticks_.end() ? given->second : before_the_first - recorded.tick};
}

void FeatureLog::emit(const Evaluation& evaluation, const RecordedSet& set, Output& output) {
  double segments = 0;
  owner_ = evaluation.owner;
  if (!set.sources.empty()) given_ticks_[set.time.tick] = evaluation.tick;
  std::vector<Source> sources;
  for (const RecordedSource& source : set.sources) sources.push_back(source_of(source));
  output.elements.resize(set.features.size());
  for (std::size_t i = 0; i < set.features.size(); ++i) {
    const RecordedFeature& feature = set.features[i];
    Estimate& element = output.elements[i];
    element.type = feature.type;
    element.frame = output.estimate.frame;
    element.value = feature.value;
    element.labels = feature.labels;
    element.lineage.reset(feature.value.size());
    for (Eigen::Index k = 0; k < feature.factor.cols(); ++k) {
      const auto column = static_cast<std::uint32_t>(k);
      element.lineage.add(
          feature.sources.empty()
              ? evaluation.fresh(columns_of_element * static_cast<std::uint32_t>(i) + column)
              : sources[feature.sources[column]],
          std::span<const double>(feature.factor.col(k).data(), feature.value.size()));
    }
    if (feature.type == &descriptor<LineSegment>() || feature.type == &descriptor<ArcSegment>())
      ++segments;
  }
  assign<RangeFeatures>(output.estimate, {segments});
  output.estimate.correlation_unknown = true;
  output.acquired = Acquisition::at(evaluation.time - duration_of(set.time.age));
}

Outcome<> FeatureLog::evaluate(const Evaluation& evaluation, Output& output) {
  for (;;) {
    const std::size_t before = next_;
    auto set = columns_ ? read_rows() : read_line();
    if (!set) {
      any_ = true;
      return set.fault();
    }
    if (*set) {
      any_ = true;
      emit(evaluation, **set, output);
      return {};
    }
    if (next_ != before && next_ < log_->lines()) continue;  // rows that were all left out
    if (!any_)
      return Fault{FaultKind::device_lost,
                   fmt::format("'{}' has no features", options_.file.string())};
    return Fault{FaultKind::end_of_data,
                 fmt::format("'{}' has no more features", options_.file.string())};
  }
}

}  // namespace ilss
