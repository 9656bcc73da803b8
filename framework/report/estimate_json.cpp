#include "framework/report/estimate_json.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "framework/estimate/budget.h"
#include "framework/report/estimate_text.h"

namespace ilss {
namespace {

Json matrix_json(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The shape, whose last index counts the numbers of a sample where it has more than one, and what
/// they are.
Json samples_json(const Samples& samples, const SamplesDescriptor& declared) {
  std::vector<std::size_t> shape = samples.shape;
  Json columns = Json::array();
  std::size_t count = 0;
  for (const SampleColumn& column : declared.columns) {
    count += column.count;
    columns.push_back({{"name", column.name},
                       {"unit", column.unit},
                       {"type", sample_type_name(column.type)},
                       {"count", column.count}});
  }
  if (count > 1) shape.push_back(count);
  return {{"shape", shape}, {"columns", std::move(columns)}};
}

/// The sources of error that the elements of a set have in common, each once.
std::vector<Source> common_sources(const Elements& elements) {
  std::vector<Source> sources;
  for (const Estimate& element : elements)
    sources.insert(sources.end(), element.lineage.sources().begin(),
                   element.lineage.sources().end());
  std::sort(sources.begin(), sources.end());
  sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
  return sources;
}

Json sources_json(std::span<const Source> sources, const SourceOwners& owners) {
  Json list = Json::array();
  for (const Source& source : sources) {
    Json entry = {{"owner", owners[source.owner].name},
                  {"column", source.column},
                  {"kind", source.persistent() ? "systematic" : "random"}};
    if (!source.persistent()) entry["tick"] = source.tick;
    list.push_back(std::move(entry));
  }
  return list;
}

/// An element's lineage: which of the common sources it has, and its factor over these.
Json factor_json(const Lineage& lineage, std::span<const Source> sources) {
  Json places = Json::array();
  for (const Source& source : lineage.sources())
    places.push_back(std::lower_bound(sources.begin(), sources.end(), source) - sources.begin());
  return {{"sources", std::move(places)}, {"matrix", matrix_json(lineage.factor())}};
}

/// What was found on an estimate's first-order error.
void add_verdict(const Estimate& estimate, const VerdictReport* verdict, Json& json) {
  json["verdict"] = nullptr;
  if (verdict == nullptr) return;
  json["verdict"] = verdict_name(verdict->verdict);
  if (!verdict->reason.empty()) json["verdict_reason"] = verdict->reason;
  if (verdict->bias.size() != estimate.dimension()) return;
  Json mean = Json::array();
  Json standard_deviation = Json::array();
  for (std::size_t i = 0; i < estimate.dimension(); ++i) {
    mean.push_back(estimate.value[i] + verdict->bias[i]);
    standard_deviation.push_back(corrected_deviation(estimate, *verdict, i));
  }
  json["second_order"] = {{"mean", std::move(mean)}, {"std", std::move(standard_deviation)}};
}

Json one_output_json(const Output& output, const SourceOwners& owners,
                     const VerdictReport* verdict) {
  Json json = estimate_json(output.estimate, owners, verdict);
  if (output.estimate.type->samples && !output.samples.shape.empty())
    json["samples"] = samples_json(output.samples, *output.estimate.type->samples);
  if (!output.estimate.type->element.empty()) {
    VerdictReport of_set;
    if (verdict != nullptr) of_set.verdict = verdict->verdict;
    const std::vector<Source> sources = common_sources(output.elements);
    json["sources"] = sources_json(sources, owners);
    Json features = Json::array();
    for (const Estimate& element : output.elements) {
      Json feature = estimate_json(element, owners, verdict == nullptr ? nullptr : &of_set);
      feature["factor"] = factor_json(element.lineage, sources);
      features.push_back(std::move(feature));
    }
    json["features"] = std::move(features);
  }
  return json;
}

/// The pairs of outputs that hold a common source, in order: only these can be correlated.
std::vector<std::pair<std::size_t, std::size_t>> related_outputs(const TickView& tick) {
  std::vector<std::pair<Source, std::size_t>> holders;
  for (std::size_t o = 0; o < tick.outputs(); ++o)
    if (const Output* output = tick.output(o).output; output != nullptr)
      for (const Source& source : output->estimate.lineage.sources())
        holders.emplace_back(source, o);
  std::sort(holders.begin(), holders.end());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t begin = 0, end = 0; begin < holders.size(); begin = end) {
    while (end < holders.size() && holders[end].first == holders[begin].first) ++end;
    for (std::size_t a = begin; a < end; ++a)
      for (std::size_t b = a + 1; b < end; ++b)
        pairs.emplace_back(holders[a].second, holders[b].second);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

std::string json_text(const Json& json, bool on_one_line) {
  return json.dump(on_one_line ? -1 : 2, ' ', false, Json::error_handler_t::replace);
}

Json estimate_json(const Estimate& estimate, const SourceOwners& owners,
                   const VerdictReport* verdict) {
  Json json;
  json["type"] = estimate.type->name;
  json["frame"] = estimate.frame;
  Json components = Json::array();
  for (std::size_t i = 0; i < estimate.dimension(); ++i)
    components.push_back({{"name", estimate.type->components[i].name},
                          {"unit", estimate.type->components[i].unit},
                          {"value", estimate.value[i]},
                          {"std", estimate.lineage.standard_deviation(i)}});
  json["components"] = std::move(components);
  if (!estimate.type->labels.empty()) {
    Json labels = Json::object();
    for (std::size_t i = 0; i < estimate.type->labels.size(); ++i) {
      const Label& label = estimate.type->labels[i];
      labels[label.name] = label.values[static_cast<std::size_t>(estimate.labels[i])];
    }
    json["labels"] = std::move(labels);
  }
  json["covariance"] = matrix_json(estimate.lineage.covariance());
  if (estimate.correlation_unknown) json["correlation"] = "unknown";
  Json entries = Json::array();
  const std::vector<BudgetEntry> parts = budget(estimate.lineage);
  for (const BudgetEntry& entry : parts)
    entries.push_back({{"source", owners[entry.owner].name},
                       {"kind", entry.persistent ? "systematic" : "random"},
                       {"variance", entry.variance}});
  json["budget"] = std::move(entries);
  for (std::size_t i = 0; i < estimate.dimension(); ++i)
    if (const double degrees = effective_degrees_of_freedom(parts, owners, i);
        std::isfinite(degrees))
      json["components"][i]["degrees_of_freedom"] = degrees;
  add_verdict(estimate, verdict, json);
  return json;
}

Json monte_carlo_json(const MonteCarloOutput& result) {
  Json json = {{"trials", result.trials}, {"faults", result.faults}};
  if (result.faults > 0) json["fault"] = result.fault;
  if (result.trials == 0) return json;
  json["mean"] = std::vector<double>(result.mean.begin(), result.mean.end());
  json["covariance"] = matrix_json(result.covariance);
  Json intervals = Json::array();
  for (const Interval& interval : result.interval)
    intervals.push_back({interval.low, interval.high});
  json["interval_95"] = std::move(intervals);
  json["coverage"] = result.coverage;
  json["joint_coverage"] = result.joint_coverage;
  json["agreeing_digits"] = result.agreeing_digits;
  return json;
}

Json fault_json(const Fault& fault, const std::string& module) {
  return {{"kind", fault_name(fault.kind)}, {"message", fault.message}, {"module", module}};
}

Json outputs_json(const TickView& tick) {
  const auto one = [&](std::size_t o) -> Json {
    const CharacteristicOutput output = tick.output(o);
    if (output.output == nullptr) return nullptr;
    return one_output_json(*output.output, tick.plan().owners, output.verdict);
  };
  if (tick.outputs() == 1) return one(0);
  Json json;
  Json outputs = Json::array();
  Json cross = Json::array();
  for (std::size_t o = 0; o < tick.outputs(); ++o) outputs.push_back(one(o));
  for (const auto& [a, b] : related_outputs(tick)) {
    const Eigen::MatrixXd covariance = cross_covariance(tick.output(a).output->estimate.lineage,
                                                        tick.output(b).output->estimate.lineage);
    if (covariance.isZero(0)) continue;
    cross.push_back({{"outputs", {a, b}}, {"covariance", matrix_json(covariance)}});
  }
  json["outputs"] = std::move(outputs);
  json["cross_covariance"] = std::move(cross);
  return json;
}

Json time_json(const TimePrediction& time, const Plan& plan) {
  Json path = Json::array();
  for (const std::size_t node : time.critical_path) path.push_back(plan.nodes[node].name);
  Json unknown = Json::array();
  for (const std::size_t node : time.unknown) unknown.push_back(plan.nodes[node].name);
  // A sum with unknown parts is no time; what is known of it has a name of its own.
  const bool known = time.unknown.empty();
  Json json = {{"typical_s", known ? Json(time.typical) : Json(nullptr)},
               {"worst_s", known ? Json(time.worst) : Json(nullptr)},
               {"known_typical_s", time.typical},
               {"known_worst_s", time.worst},
               {"critical_path", std::move(path)},
               {"unknown", std::move(unknown)}};
  return json;
}

}  // namespace ilss
