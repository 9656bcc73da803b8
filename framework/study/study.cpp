#include "framework/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "framework/estimate/units.h"
#include "framework/graph/value_reader.h"
#include "framework/record/table.h"
#include "framework/study/judge_reader.h"
#include "framework/study/study_settings.h"

namespace ilss {
namespace {

/// The keys of a study that hold one plain value each.
struct StudyOptions {
  std::string study;
  std::string description;
  std::string payload;
  std::int64_t runs = 200;
  std::int64_t seed = 1;
  bool draw_systematic_errors = true;

  void declare(OptionVisitor& visit) {
    visit("study", study, "the study's name", {.required = true});
    visit("description", description, "what it is about");
    visit("payload", payload, "what is compared", {.required = true});
    visit("runs", runs, "how often each system runs in each case", {.minimum = 1, .maximum = 1e9});
    visit("seed", seed, "of the random errors", {.minimum = 0});
    visit("draw_systematic_errors", draw_systematic_errors,
          "whether each run draws the errors of constants anew, beside the random ones");
  }
};

/// Where a component stands in a recording.
struct RecordedColumn {
  std::string column;
  std::string unit;

  void declare(OptionVisitor& visit) {
    visit("column", column, "its name in the first row", {.required = true});
    visit("unit", unit, "of the numbers; by default the component's SI unit");
  }
};

/// The truth or an alternative as the file states it: one value a row of a recording, or a graph.
struct Side {
  std::string name;
  Position position;
  bool stated = false;  ///< whether it is a recording or a graph at all
  bool valid = false;
  bool recorded = false;
  std::vector<Outcome<Estimate>> rows = {};
  Node graph = {};
  std::filesystem::path directory = {};
};

std::vector<std::string> component_names(const PayloadDescriptor& payload) {
  std::vector<std::string> names;
  for (const Component& component : payload.components) names.push_back(component.name);
  return names;
}

class StudyReader {
 public:
  StudyReader(const Node& root, std::filesystem::path directory, const Registry& registry,
              Diagnostics& diagnostics)
      : root_(root),
        directory_(std::move(directory)),
        registry_(registry),
        diagnostics_(diagnostics) {}

  std::optional<Study> read();

 private:
  void read_payload(const std::string& name);
  void read_requirement();
  Side read_side(const std::string& name, const Node& node, Position position);
  void read_rows(const Node& node, Side& side);
  std::optional<std::size_t> read_column(const Node& node, const Component& component,
                                         const Table& recording, UnitConversion& conversion);
  std::vector<Side> read_alternatives();
  void check_kinds(const std::vector<Side>& sides);
  void add_recorded_cases(const std::vector<Side>& sides);
  std::vector<std::string> read_recorded_names(std::size_t rows);
  void add_system_cases(const std::vector<Side>& sides);
  void check_constants(const std::vector<Side>& sides, std::vector<Setting>& settings);
  std::optional<Plan> read_plan_of(const Side& side, const Setting& setting);
  const Table& recording(const Node& path);

  const Node& root_;
  std::filesystem::path directory_;
  const Registry& registry_;
  Diagnostics& diagnostics_;
  Study study_;
  std::map<std::filesystem::path, Table> recordings_;
  std::optional<Side> tolerated_;
};

std::optional<Study> StudyReader::read() {
  const std::size_t errors = diagnostics_.size();
  if (!root_.is_map()) {
    diagnostics_.add(root_.position,
                     "expected a study: a map with the keys study, payload, truth and "
                     "alternatives, got " +
                         root_.description());
    return std::nullopt;
  }
  if (root_.find("network") != nullptr && root_.find("alternatives") == nullptr) {
    diagnostics_.add(root_.position,
                     "this is a graph, not a study; `ilss predict` and `ilss run` "
                     "take it");
    return std::nullopt;
  }
  std::vector<std::string> known = {"requirement",     "truth",     "alternatives",
                                    "cases",           "sweep",     "judge",
                                    "validation_gate", "reference", "tolerated"};
  for (const ParameterDeclaration& d : declare_options<StudyOptions>()) known.push_back(d.name);
  check_map_keys(root_, "a study", known, diagnostics_);
  const auto options = read_options<StudyOptions>(&root_, directory_, diagnostics_, root_.position);
  study_.name = options.study;
  study_.description = options.description;
  study_.runs = options.runs;
  study_.seed = static_cast<std::uint64_t>(options.seed);
  study_.draw_systematic_errors = options.draw_systematic_errors;
  read_payload(options.payload);
  // Without a payload no value can be read: what else is wrong would be guesswork.
  if (study_.payload == nullptr) return std::nullopt;
  read_requirement();
  std::vector<Side> sides = read_alternatives();
  const Node* truth = root_.find("truth");
  if (truth == nullptr)
    diagnostics_.add(root_.position, "a study needs a truth: {recorded: ...} or {graph: ...}");
  else
    sides.insert(sides.begin(), read_side("truth", *truth, truth->position));
  if (sides.empty() || truth == nullptr || !sides.front().stated) return std::nullopt;
  if (const Node* tolerated = root_.find("tolerated"))
    tolerated_ = read_side("tolerated", *tolerated, tolerated->position);
  if (tolerated_) sides.push_back(*tolerated_);
  check_kinds(sides);
  if (study_.compares_sets() && sides.front().recorded)
    diagnostics_.add(sides.front().position,
                     "a study of sets compares graphs; recordings hold no sets");
  read_set_keys(root_, study_, diagnostics_);
  study_.recorded = sides.front().recorded;
  if (study_.recorded)
    add_recorded_cases(sides);
  else
    add_system_cases(sides);
  if (diagnostics_.size() != errors) return std::nullopt;
  return std::move(study_);
}

void StudyReader::read_payload(const std::string& name) {
  const Node* node = root_.find("payload");
  if (node == nullptr || !node->is_scalar()) return;
  study_.payload = registry_.find_payload(name);
  if (study_.payload == nullptr) {
    std::vector<std::string> names;
    for (const ModuleType* type : registry_.types())
      if (const auto* output = type->interface({}).output; output != &any_payload())
        names.push_back(output->name);
    diagnostics_.add(node->position, fmt::format("no module gives a payload '{}'{}", name,
                                                 suggestion(name, names)));
  } else if (study_.payload->dimension() == 0) {
    diagnostics_.add(node->position, fmt::format("'{}' has no components to compare", name));
    study_.payload = nullptr;
  }
}

void StudyReader::read_requirement() {
  study_.requirement.resize(study_.payload->dimension());
  const Node* requirement = root_.find("requirement");
  if (requirement == nullptr) return;
  if (!requirement->is_map()) {
    diagnostics_.add(
        requirement->position,
        "expected a map of components to their largest errors, got " + requirement->description());
    return;
  }
  check_map_keys(*requirement, study_.payload->name, component_names(*study_.payload),
                 diagnostics_);
  for (std::size_t i = 0; i < study_.payload->dimension(); ++i) {
    const Component& component = study_.payload->components[i];
    const Node* limit = requirement->find(component.name);
    if (limit == nullptr) continue;
    if (!limit->is_scalar()) {
      diagnostics_.add(limit->position, "expected the largest error, " +
                                            dimension_name(component.unit) + ", got " +
                                            limit->description());
      continue;
    }
    const auto value = parse_quantity(limit->text, component.unit);
    if (const auto* error = std::get_if<std::string>(&value))
      diagnostics_.add(limit->position, *error);
    else if (!(std::get<double>(value) > 0))
      diagnostics_.add(limit->position,
                       fmt::format("the largest error must be above 0, got '{}'", limit->text));
    else
      study_.requirement[i] = std::get<double>(value);
  }
}

Side StudyReader::read_side(const std::string& name, const Node& node, Position position) {
  Side side{name, position};
  const Node* graph = node.is_map() ? node.find("graph") : nullptr;
  const Node* recorded = node.is_map() ? node.find("recorded") : nullptr;
  if ((graph == nullptr) == (recorded == nullptr)) {
    diagnostics_.add(node.is_null() ? position : node.position,
                     fmt::format("{} needs either recorded: FILE or graph: {{...}}", name));
    return side;
  }
  side.stated = true;
  side.recorded = recorded != nullptr;
  const std::size_t errors = diagnostics_.size();
  if (side.recorded) {
    check_map_keys(node, name, {"recorded", "columns"}, diagnostics_);
    read_rows(node, side);
  } else {
    check_map_keys(node, name, {"graph"}, diagnostics_);
    side.directory = directory_;
    side.graph = *graph;
    if (graph->is_scalar()) {
      const std::filesystem::path file = directory_ / graph->text;
      side.graph = read_document(file, diagnostics_);
      side.directory = file.parent_path();
    }
  }
  side.valid = diagnostics_.size() == errors;
  return side;
}

const Table& StudyReader::recording(const Node& path) {
  const std::filesystem::path file = directory_ / path.text;
  const auto known = recordings_.find(file);
  if (known != recordings_.end()) return known->second;
  return recordings_[file] = read_table(file, diagnostics_);
}

void StudyReader::read_rows(const Node& node, Side& side) {
  const Node& path = *node.find("recorded");
  const Node* columns = node.find("columns");
  if (!path.is_scalar())
    diagnostics_.add(path.position, "expected a path, got " + path.description());
  if (columns == nullptr || !columns->is_map()) {
    diagnostics_.add(
        columns == nullptr ? node.position : columns->position,
        fmt::format("{} needs columns: a map of components to {{column, unit}}", side.name));
    return;
  }
  check_map_keys(*columns, study_.payload->name, component_names(*study_.payload), diagnostics_);
  if (!path.is_scalar()) return;
  const Table& table = recording(path);
  if (table.columns.empty()) return;
  for (const Component& component : study_.payload->components)
    if (columns->find(component.name) == nullptr)
      diagnostics_.add(columns->position, fmt::format("{} needs a column for {}'s '{}'", side.name,
                                                      study_.payload->name, component.name));
  side.rows.assign(table.rows.size(), Estimate(*study_.payload));
  for (std::size_t c = 0; c < study_.payload->dimension(); ++c) {
    const Component& component = study_.payload->components[c];
    const Node* node_of_column = columns->find(component.name);
    if (node_of_column == nullptr) continue;
    UnitConversion conversion;
    const auto column = read_column(*node_of_column, component, table, conversion);
    if (!column) continue;
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const TableCell& cell = table.rows[r][*column];
      if (cell.text.empty()) {
        side.rows[r] = Fault{FaultKind::no_detection,
                             fmt::format("the recording has no '{}' here", component.name)};
        continue;
      }
      const auto number = parse_quantity(cell.text, "1");
      if (std::holds_alternative<std::string>(number)) {
        diagnostics_.add(cell.position, fmt::format("expected a number, got '{}'", cell.text));
        continue;
      }
      if (!side.rows[r]) continue;
      (*side.rows[r]).value[c] = conversion.scale * std::get<double>(number) + conversion.offset;
    }
  }
  for (Outcome<Estimate>& row : side.rows)
    if (row) normalize(*study_.payload, (*row).value);
}

std::optional<std::size_t> StudyReader::read_column(const Node& node, const Component& component,
                                                    const Table& recording,
                                                    UnitConversion& conversion) {
  if (!node.is_map()) {
    diagnostics_.add(node.position,
                     "expected {column: NAME, unit: UNIT}, got " + node.description());
    return std::nullopt;
  }
  check_keys(node, declare_options<RecordedColumn>(), component.name, diagnostics_);
  const auto options = read_options<RecordedColumn>(&node, directory_, diagnostics_, node.position);
  if (options.column.empty()) return std::nullopt;
  const auto column = recording.find(options.column);
  if (!column)
    diagnostics_.add(node.find("column")->position,
                     fmt::format("the recording has no column '{}'{}", options.column,
                                 suggestion(options.column, recording.columns)));
  if (options.unit.empty()) return column;
  const auto converted = unit_conversion(options.unit, component.unit);
  if (const auto* error = std::get_if<std::string>(&converted))
    diagnostics_.add(node.find("unit")->position, *error);
  else
    conversion = std::get<UnitConversion>(converted);
  return column;
}

std::vector<Side> StudyReader::read_alternatives() {
  std::vector<Side> sides;
  const Node* alternatives = root_.find("alternatives");
  if (alternatives == nullptr || !alternatives->is_map() || alternatives->size() == 0) {
    diagnostics_.add(alternatives == nullptr ? root_.position : alternatives->position,
                     "a study needs alternatives: a map of names to {recorded: ...} or "
                     "{graph: ...}");
    return sides;
  }
  for (std::size_t i = 0; i < alternatives->size(); ++i) {
    const Node& key = alternatives->keys[i];
    if (key.text == "truth")
      diagnostics_.add(key.position, "an alternative cannot be named 'truth'");
    study_.alternatives.push_back(key.text);
    sides.push_back(read_side(key.text, alternatives->values[i], key.position));
  }
  return sides;
}

void StudyReader::check_kinds(const std::vector<Side>& sides) {
  for (const Side& side : sides)
    if (side.stated && side.recorded != sides.front().recorded)
      diagnostics_.add(side.position,
                       fmt::format("'{}' is {}, but the truth is {}; a study compares either "
                                   "recordings or graphs",
                                   side.name, side.recorded ? "a recording" : "a graph",
                                   sides.front().recorded ? "a recording" : "a graph"));
}

void StudyReader::add_recorded_cases(const std::vector<Side>& sides) {
  for (const char* key : {"sweep", "runs", "seed", "draw_systematic_errors"})
    if (const Node* node = root_.find(key))
      diagnostics_.add(
          node->position,
          fmt::format("'{}' is for studies of graphs; this one compares recordings", key));
  const Side& truth = sides.front();
  if (truth.valid && truth.rows.empty())
    diagnostics_.add(truth.position, "the recording has no rows");
  for (const Side& side : sides)
    if (truth.valid && side.valid && side.recorded && side.rows.size() != truth.rows.size())
      diagnostics_.add(side.position, fmt::format("'{}' has {} rows, but the truth has {}",
                                                  side.name, side.rows.size(), truth.rows.size()));
  const std::vector<std::string> names = read_recorded_names(truth.rows.size());
  const auto complete = [&](const Side& side) { return side.rows.size() == names.size(); };
  if (!std::all_of(sides.begin(), sides.end(), complete)) return;
  study_.runs = 1;
  for (std::size_t r = 0; r < names.size(); ++r) {
    StudyCase& one = study_.cases.emplace_back(StudyCase{names[r], truth.rows[r], {}});
    for (const Side& side : std::span(sides).subspan(1))
      one.alternatives.emplace_back(side.rows[r]);
  }
}

std::vector<std::string> StudyReader::read_recorded_names(std::size_t rows) {
  std::vector<std::string> names;
  for (std::size_t r = 0; r < rows; ++r) names.push_back(std::to_string(r + 1));
  study_.case_noun = "row";
  const Node* cases = root_.find("cases");
  if (cases == nullptr) return names;
  const Node* path = cases->is_map() ? cases->find("recorded") : nullptr;
  const Node* column_node = cases->is_map() ? cases->find("name") : nullptr;
  if (path == nullptr || column_node == nullptr || !path->is_scalar() ||
      !column_node->is_scalar()) {
    diagnostics_.add(cases->position, "expected {recorded: FILE, name: COLUMN}");
    return names;
  }
  check_map_keys(*cases, "cases", {"recorded", "name"}, diagnostics_);
  const Table& table = recording(*path);
  if (table.columns.empty()) return names;
  const auto column = table.find(column_node->text);
  if (!column) {
    diagnostics_.add(column_node->position,
                     fmt::format("the recording has no column '{}'{}", column_node->text,
                                 suggestion(column_node->text, table.columns)));
    return names;
  }
  if (table.rows.size() != rows) {
    diagnostics_.add(path->position, fmt::format("the cases have {} rows, but the truth has {}",
                                                 table.rows.size(), rows));
    return names;
  }
  study_.case_noun = column_node->text;
  for (std::size_t r = 0; r < rows; ++r) names[r] = table.rows[r][*column].text;
  return names;
}

void StudyReader::add_system_cases(const std::vector<Side>& sides) {
  std::vector<Setting> settings = read_settings(root_, diagnostics_);
  check_constants(sides, settings);
  for (const Setting& setting : settings) {
    std::vector<std::optional<Plan>> plans;
    plans.reserve(sides.size());
    for (const Side& side : sides)
      plans.push_back(side.valid && !side.recorded ? read_plan_of(side, setting) : std::nullopt);
    if (!std::all_of(plans.begin(), plans.end(), [](const auto& plan) { return plan.has_value(); }))
      continue;
    const std::string frame = plans.front()->nodes[plans.front()->outputs.front()].frame;
    StudyCase one{setting.name, std::move(*plans.front()), {}};
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const std::string& other = plans[i]->nodes[plans[i]->outputs.front()].frame;
      if (!frame.empty() && !other.empty() && frame != other)
        diagnostics_.add(sides[i].position,
                         fmt::format("'{}' gives {} in frame '{}', but the truth is in frame '{}'; "
                                     "put a transform at its end",
                                     sides[i].name, study_.payload->name, other, frame));
      one.alternatives.emplace_back(std::move(*plans[i]));
    }
    if (tolerated_) {
      one.tolerated = std::get<Plan>(std::move(one.alternatives.back()));
      one.alternatives.pop_back();
    }
    study_.cases.push_back(std::move(one));
  }
}

void StudyReader::check_constants(const std::vector<Side>& sides, std::vector<Setting>& settings) {
  const std::size_t prefix = std::string_view("constants.").size();
  for (Setting& setting : settings)
    std::erase_if(setting.constants, [&](const Override& constant) {
      const std::string name = constant.path.substr(prefix);
      std::vector<std::string> lacking;
      std::vector<std::string> others;
      for (const Side& side : sides) {
        if (!side.valid || side.recorded) continue;
        const Node* constants = side.graph.find("constants");
        if (constants != nullptr && constants->find(name) != nullptr) continue;
        lacking.push_back(side.name);
        for (std::size_t i = 0; constants != nullptr && i < constants->keys.size(); ++i)
          others.push_back(constants->keys[i].text);
      }
      if (lacking.empty()) return false;
      diagnostics_.add(constant.position,
                       fmt::format("there is no constant '{}' in the graph of {}{}", name,
                                   fmt::join(lacking, ", "), suggestion(name, others)));
      return true;
    });
}

std::optional<Plan> StudyReader::read_plan_of(const Side& side, const Setting& setting) {
  auto plan = build_plan(side.graph, side.directory, registry_, setting.constants, diagnostics_);
  if (!plan) return plan;
  if (plan->outputs.size() != 1) {
    diagnostics_.add(side.position, fmt::format("'{}' has {} outputs; a study compares one",
                                                side.name, plan->outputs.size()));
    return std::nullopt;
  }
  const PlanNode& output = plan->nodes[plan->outputs.front()];
  if (output.interface.output->name == study_.payload->name) return plan;
  diagnostics_.add(side.position, fmt::format("'{}' gives {}, but the study compares {}", side.name,
                                              output.interface.output->name, study_.payload->name));
  return std::nullopt;
}

}  // namespace

std::optional<Study> read_study(const std::filesystem::path& file, const Registry& registry,
                                Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.size();
  const Node root = read_document(file, diagnostics);
  if (root.is_null() && diagnostics.size() != errors) return std::nullopt;
  return StudyReader(root, file.parent_path(), registry, diagnostics).read();
}

}  // namespace ilss
