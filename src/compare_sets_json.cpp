#include "src/compare_report.h"

namespace ilss {
namespace {

Json faults_json(const std::map<FaultKind, FaultCount>& faults) {
  Json json = Json::array();
  for (const auto& [kind, fault] : faults)
    json.push_back(
        {{"kind", fault_name(kind)}, {"count", fault.count}, {"message", fault.message}});
  return json;
}

Json rule_json(const ElementRule& rule) {
  Json json = {{"type", rule.type->name}};
  Json components = Json::array();
  for (const std::size_t c : rule.judged)
    components.push_back(
        {{"name", rule.type->components[c].name}, {"unit", rule.type->components[c].unit}});
  json["components"] = std::move(components);
  if (rule.interval)
    json["least_overlap"] = rule.overlap;
  else
    json["largest_distance"] = rule.gate;
  Json only = Json::object();
  for (const auto& [label, value] : rule.only)
    only[rule.type->labels[label].name] =
        rule.type->labels[label].values[static_cast<std::size_t>(value)];
  json["only"] = std::move(only);
  return json;
}

Json consistency_json(const ElementScore& score) {
  if (score.consistency.degrees_of_freedom() <= 0) return nullptr;
  const Interval bounds = score.nees_bounds(consistency_probability);
  return {{"nees", score.mean_nees()},
          {"nees_per_degree_of_freedom", score.consistency.mean()},
          {"degrees_of_freedom", score.consistency.degrees_of_freedom()},
          {"nees_bounds_99", {bounds.low, bounds.high}},
          {"inside_bounds", score.consistency.consistent(consistency_probability)},
          {"coverage_95", score.inside_95_share()},
          {"largest_unexplained_error", score.consistency.unexplained()}};
}

Json score_json(const Study& study, const ElementRule& rule, const ElementScore& score) {
  Json json = {{"type", rule.type->name},
               {"true", score.truth},
               {"found", score.found},
               {"matched", score.matched},
               {"tolerated", score.tolerated},
               {"true_positive", score.true_positive()},
               {"false_positive", score.false_positive()}};
  Json components = Json::array();
  for (std::size_t j = 0; j < score.errors.size(); ++j) {
    const MatchedErrors& errors = score.errors[j];
    Json component = {{"name", rule.type->components[rule.judged[j]].name},
                      {"bias", errors.bias},
                      {"std", errors.standard_deviation},
                      {"median_error", errors.median}};
    if (!score.relative_deviation.empty())
      component["std_over_reference"] = score.relative_deviation[j];
    components.push_back(std::move(component));
  }
  json["components"] = std::move(components);
  if (!rule.interval && score.matched > 0) json["median_distance"] = score.median_distance;
  json["consistency"] = consistency_json(score);
  if (study.validation_gate && score.matched > 0)
    json["share_inside_validation_gate"] = score.inside_gate_share();
  return json;
}

Json alternative_json(const Study& study, std::size_t a, const SetAlternative& alternative) {
  constexpr double nanosecond = 1e-9;
  const LatencySummary time = alternative.time.summary();
  Json elements = Json::array();
  for (std::size_t e = 0; e < study.judged.size(); ++e)
    elements.push_back(score_json(study, study.judged[e], alternative.scores[e]));
  return {{"name", study.alternatives[a]},
          {"outputs", alternative.outputs},
          {"pending", alternative.pending},
          {"faults", faults_json(alternative.faults)},
          {"time",
           {{"median_s", static_cast<double>(time.p50) * nanosecond},
            {"p99_s", static_cast<double>(time.p99) * nanosecond},
            {"max_s", static_cast<double>(time.max) * nanosecond}}},
          {"elements", std::move(elements)}};
}

}  // namespace

Json set_comparison_json(const Study& study, const std::vector<SetCase>& cases) {
  Json json = {{"study", study.name}, {"description", study.description},
               {"kind", "sets"},      {"payload", study.payload->name},
               {"runs", study.runs},  {"seed", study.seed}};
  json["validation_gate"] = study.validation_gate ? Json(*study.validation_gate) : Json(nullptr);
  json["reference"] = study.reference ? Json(study.alternatives[*study.reference]) : Json(nullptr);
  Json judged = Json::array();
  for (const ElementRule& rule : study.judged) judged.push_back(rule_json(rule));
  json["judge"] = std::move(judged);
  Json list = Json::array();
  for (const SetCase& compared : cases) {
    Json alternatives = Json::array();
    for (std::size_t a = 0; a < compared.alternatives.size(); ++a)
      alternatives.push_back(alternative_json(study, a, compared.alternatives[a]));
    list.push_back({{"name", compared.name},
                    {"ticks", compared.ticks},
                    {"truth_faults", faults_json(compared.truth_faults)},
                    {"alternatives", std::move(alternatives)}});
  }
  json["cases"] = std::move(list);
  return json;
}

}  // namespace ilss
