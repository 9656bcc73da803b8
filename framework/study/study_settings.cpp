#include "framework/study/study_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "framework/estimate/units.h"
#include "framework/graph/value_reader.h"

namespace ilss {
namespace {

constexpr std::size_t most_cases = 10'000;

std::vector<Setting> read_case_list(const Node& list, Diagnostics& diagnostics) {
  std::vector<Setting> settings;
  if (!list.is_list() || list.size() == 0 || list.size() > most_cases) {
    diagnostics.add(list.position,
                    fmt::format("expected a list of 1 to {} cases, each {{name, CONSTANT: VALUE}}",
                                most_cases));
    return settings;
  }
  std::set<std::string> names;
  for (const Node& entry : list.values) {
    const Node* name = entry.is_map() ? entry.find("name") : nullptr;
    if (name == nullptr || !name->is_scalar()) {
      diagnostics.add(entry.position, "a case needs a name");
      continue;
    }
    if (!names.insert(name->text).second)
      diagnostics.add(name->position, fmt::format("a second case is named '{}'", name->text));
    Setting& setting = settings.emplace_back(Setting{name->text, {}});
    for (std::size_t i = 0; i < entry.size(); ++i)
      if (entry.keys[i].text != "name")
        setting.constants.push_back(
            {"constants." + entry.keys[i].text, entry.values[i], entry.keys[i].position});
  }
  return settings;
}

std::vector<Node> read_sweep_values(const Node& name, const Node& range, Diagnostics& diagnostics) {
  const Node* ends[2] = {range.find("from"), range.find("to")};
  const Node* steps_node = range.find("steps");
  if (!range.is_map() || ends[0] == nullptr || ends[1] == nullptr || steps_node == nullptr) {
    diagnostics.add(range.position, fmt::format("'{}' needs from, to and steps", name.text));
    return {};
  }
  const std::size_t errors = diagnostics.size();
  check_map_keys(range, name.text, {"from", "to", "steps"}, diagnostics);
  const auto from = read_quantity(*ends[0], diagnostics);
  const auto to = read_quantity(*ends[1], diagnostics);
  const auto steps = parse_quantity(steps_node->is_scalar() ? steps_node->text : "", "1");
  const double* count = std::get_if<double>(&steps);
  if (count == nullptr || *count < 2 || *count > static_cast<double>(most_cases) ||
      *count != static_cast<double>(static_cast<std::int64_t>(*count)))
    diagnostics.add(steps_node->position,
                    fmt::format("expected a whole number of steps from 2 to {}, got {}", most_cases,
                                steps_node->description()));
  if (diagnostics.size() != errors) return {};
  // A bare 0 takes the other end's unit.
  const std::string unit = from->unit.empty() && from->number == 0 ? to->unit : from->unit;
  UnitConversion conversion;
  if (to->unit != unit && !(to->unit.empty() && to->number == 0)) {
    const auto converted =
        unit_conversion(to->unit.empty() ? "1" : to->unit, unit.empty() ? "1" : unit);
    if (const auto* error = std::get_if<std::string>(&converted)) {
      diagnostics.add(to->position, *error);
      return {};
    }
    conversion = std::get<UnitConversion>(converted);
  }
  const double last = conversion.scale * to->number + conversion.offset;
  std::vector<Node> values;
  for (int i = 0; i < static_cast<int>(*count); ++i) {
    const double number = from->number + (last - from->number) * i / (*count - 1);
    // Rounded to where binary fractions do not show: the name of the case is this text.
    values.push_back({Node::Kind::scalar, range.position, false,
                      fmt::format("{:.12g}{}{}", number, unit.empty() ? "" : " ", unit)});
  }
  return values;
}

std::vector<Setting> read_sweep(const Node& map, Diagnostics& diagnostics) {
  if (!map.is_map() || map.size() == 0) {
    diagnostics.add(map.position,
                    "expected a map of constants to {from, to, steps}, got " + map.description());
    return {};
  }
  // Every value of one constant with every value of the others.
  std::vector<Setting> settings = {{}};
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::vector<Node> values = read_sweep_values(map.keys[i], map.values[i], diagnostics);
    if (values.empty()) return {};
    if (settings.size() * values.size() > most_cases) {
      diagnostics.add(map.position, fmt::format("a sweep has at most {} cases", most_cases));
      return {};
    }
    std::vector<Setting> grid;
    for (const Setting& setting : settings)
      for (const Node& value : values) {
        Setting& next = grid.emplace_back(setting);
        next.name +=
            fmt::format("{}{} {}", next.name.empty() ? "" : ", ", map.keys[i].text, value.text);
        next.constants.push_back({"constants." + map.keys[i].text, value, map.keys[i].position});
      }
    settings = std::move(grid);
  }
  return settings;
}

}  // namespace

void check_map_keys(const Node& map, std::string_view owner, const std::vector<std::string>& known,
                    Diagnostics& diagnostics) {
  for (const Node& key : map.keys)
    if (std::find(known.begin(), known.end(), key.text) == known.end())
      diagnostics.add(key.position, fmt::format("{} has no key '{}'{}", owner, key.text,
                                                suggestion(key.text, known)));
}

std::vector<Setting> read_settings(const Node& study, Diagnostics& diagnostics) {
  const Node* cases = study.find("cases");
  const Node* sweep = study.find("sweep");
  if ((cases == nullptr) == (sweep == nullptr)) {
    diagnostics.add(sweep == nullptr ? study.position : sweep->position,
                    "a study of graphs needs either cases: a list of {name, CONSTANT: VALUE}, or "
                    "sweep: {CONSTANT: {from, to, steps}}");
    return {};
  }
  return cases != nullptr ? read_case_list(*cases, diagnostics) : read_sweep(*sweep, diagnostics);
}

}  // namespace ilss
