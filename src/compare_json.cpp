#include "src/compare_report.h"

namespace ilss {
namespace {

Json fault_json(const Fault& fault) {
  return {{"kind", fault_name(fault.kind)}, {"message", fault.message}};
}

Json prediction_json(const Study& study, const CasePrediction& prediction) {
  Json json;
  json["fault"] = prediction.fault ? fault_json(*prediction.fault) : Json(nullptr);
  Json components = Json::array();
  for (std::size_t c = 0; c < prediction.value.size(); ++c)
    components.push_back({{"name", study.payload->components[c].name},
                          {"value", prediction.value[c]},
                          {"std", prediction.standard_deviation[c]}});
  json["components"] = std::move(components);
  json["verdict"] =
      prediction.verdict ? Json(verdict_name(prediction.verdict->verdict)) : Json(nullptr);
  // A sum with unknown parts is no time; what is known of it has a name of its own.
  const bool known = prediction.time_known();
  json["time"] = {{"typical_s", known ? Json(prediction.time.typical) : Json(nullptr)},
                  {"worst_s", known ? Json(prediction.time.worst) : Json(nullptr)},
                  {"known_typical_s", prediction.time.typical},
                  {"known_worst_s", prediction.time.worst},
                  {"unknown", prediction.unknown}};
  return json;
}

Json consistency_json(const ConsistencyStatistic& consistency) {
  if (consistency.degrees_of_freedom() <= 0) return nullptr;
  const Interval bounds = consistency.bounds(consistency_probability);
  return {{"nees_per_degree_of_freedom", consistency.mean()},
          {"degrees_of_freedom", consistency.degrees_of_freedom()},
          {"bounds_99", {bounds.low, bounds.high}},
          {"inside_bounds", consistency.consistent(consistency_probability)},
          {"largest_unexplained_error", consistency.unexplained()}};
}

Json measurement_json(const Study& study, const CaseMeasurement& measurement) {
  constexpr double nanosecond = 1e-9;
  Json json = {{"runs", measurement.runs},
               {"outputs", measurement.outputs},
               {"pending", measurement.pending}};
  Json faults = Json::array();
  for (const auto& [kind, fault] : measurement.faults)
    faults.push_back(
        {{"kind", fault_name(kind)}, {"count", fault.count}, {"message", fault.message}});
  json["faults"] = std::move(faults);
  Json components = Json::array();
  for (std::size_t c = 0; c < measurement.value.size(); ++c) {
    Json component = {{"name", study.payload->components[c].name}, {"value", measurement.value[c]}};
    if (c < measurement.errors.size()) {
      const ComponentErrors& errors = measurement.errors[c];
      if (study.recorded)
        component["error"] = errors.bias;
      else
        component.update(Json{{"bias", errors.bias},
                              {"std", errors.standard_deviation},
                              {"rms_error", errors.rms},
                              {"coverage_95", errors.coverage}});
    }
    components.push_back(std::move(component));
  }
  json["components"] = std::move(components);
  if (study.recorded) return json;
  json["consistency"] = consistency_json(measurement.consistency);
  const LatencySummary time = measurement.time->summary();
  json["time"] = {{"median_s", static_cast<double>(time.p50) * nanosecond},
                  {"p99_s", static_cast<double>(time.p99) * nanosecond},
                  {"max_s", static_cast<double>(time.max) * nanosecond}};
  return json;
}

Json judgement_json(const Study& study, const CaseAlternative& alternative) {
  if (!alternative.judged) return nullptr;
  Json misses = Json::array();
  for (const Miss& miss : alternative.misses)
    misses.push_back({{"component", study.payload->components[miss.component].name},
                      {"error", miss.error},
                      {"limit", miss.limit},
                      {"excess", miss.excess()}});
  return {{"met", alternative.meets_requirement},
          {"misses", std::move(misses)},
          {"share_of_runs_inside", static_cast<double>(alternative.measurement.inside) /
                                       static_cast<double>(alternative.measurement.runs)}};
}

Json case_json(const Study& study, const ComparedCase& compared) {
  Json json = {{"name", compared.name}};
  Json truth = Json::array();
  for (std::size_t c = 0; c < compared.truth.size(); ++c)
    truth.push_back({{"name", study.payload->components[c].name}, {"value", compared.truth[c]}});
  json["truth"] = compared.truth_fault ? Json(nullptr) : Json{{"components", std::move(truth)}};
  if (compared.truth_fault) json["truth_fault"] = fault_json(*compared.truth_fault);
  Json alternatives = Json::array();
  for (std::size_t a = 0; a < compared.alternatives.size(); ++a) {
    const CaseAlternative& alternative = compared.alternatives[a];
    Json entry = {{"name", study.alternatives[a]}};
    if (alternative.prediction)
      entry["predicted"] = prediction_json(study, *alternative.prediction);
    entry["measured"] = measurement_json(study, alternative.measurement);
    entry["requirement"] = judgement_json(study, alternative);
    alternatives.push_back(std::move(entry));
  }
  json["alternatives"] = std::move(alternatives);
  return json;
}

Json summary_json(const Study& study, const Comparison& comparison) {
  Json json = Json::array();
  for (std::size_t a = 0; a < comparison.summary.size(); ++a) {
    const AlternativeSummary& summary = comparison.summary[a];
    Json components = Json::array();
    for (std::size_t c = 0; c < summary.rms.size(); ++c)
      components.push_back(
          {{"name", study.payload->components[c].name}, {"rms_error", summary.rms[c]}});
    json.push_back({{"name", study.alternatives[a]},
                    {"components", std::move(components)},
                    {"cases", summary.cases},
                    {"cases_judged", summary.judged},
                    {"cases_met", summary.met}});
  }
  return json;
}

}  // namespace

Json comparison_json(const Study& study, const Comparison& comparison) {
  Json json = {{"study", study.name},
               {"description", study.description},
               {"kind", study.recorded ? "recordings" : "graphs"},
               {"payload", study.payload->name}};
  Json components = Json::array();
  for (std::size_t c = 0; c < study.payload->dimension(); ++c)
    components.push_back(
        {{"name", study.payload->components[c].name},
         {"unit", study.payload->components[c].unit},
         {"largest_error", study.requirement[c] ? Json(*study.requirement[c]) : Json(nullptr)}});
  json["components"] = std::move(components);
  if (!study.recorded) {
    json["runs"] = study.runs;
    json["seed"] = study.seed;
    json["draw_systematic_errors"] = study.draw_systematic_errors;
  }
  Json cases = Json::array();
  for (const ComparedCase& compared : comparison.cases) cases.push_back(case_json(study, compared));
  json["cases"] = std::move(cases);
  json["summary"] = summary_json(study, comparison);
  json["requirement_met"] =
      study.has_requirement() ? Json(comparison.requirement_met) : Json(nullptr);
  return json;
}

}  // namespace ilss
