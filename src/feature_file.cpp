#include "src/feature_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "framework/report/estimate_json.h"
#include "src/session.h"

namespace ilss {
namespace {

constexpr std::array<const char*, 5> leading_columns = {"tick", "time", "acquired", "frame",
                                                        "type"};

/// A text as a CSV cell: in quotes where it holds what would end it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

/// The payload of the plan's one output, which must be a set.
const PayloadDescriptor& set_of(const Plan& plan) {
  if (plan.outputs.size() != 1)
    fail(exit_bad_input,
         fmt::format("--features: the graph gives {} outputs; expected one, a set of features",
                     plan.outputs.size()));
  const PayloadDescriptor& payload = *plan.nodes[plan.outputs.front()].interface.output;
  if (payload.element.empty())
    fail(exit_bad_input,
         fmt::format("--features: the graph gives {}, which is no set of features", payload.name));
  return payload;
}

}  // namespace

/// The column of a name, which is added where it is new.
std::size_t FeatureFile::Columns::place(const std::string& name) {
  const auto column =
      static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  if (column == names.size()) names.push_back(name);
  return column;
}

FeatureFile::Columns::Columns(const PayloadDescriptor& set)
    : names(leading_columns.begin(), leading_columns.end()) {
  for (const PayloadDescriptor* type : set.elements) types.push_back({type, {}, {}, {}});
  for (Type& type : types)
    for (const Label& label : type.type->labels) type.labels.push_back(place(label.name));
  for (Type& type : types)
    for (const Component& component : type.type->components)
      type.components.push_back(place(component.name));
  for (Type& type : types) {
    const std::vector<Component>& components = type.type->components;
    for (std::size_t i = 0; i < components.size(); ++i)
      for (std::size_t j = i; j < components.size(); ++j)
        type.covariances.push_back(
            place(fmt::format("covariance.{}.{}", components[i].name, components[j].name)));
  }
}

FeatureFile::FeatureFile(const std::string& path, const Plan& plan) {
  const PayloadDescriptor& set = set_of(plan);
  const std::string format = std::filesystem::path(path).extension().string();
  if (format != ".csv" && format != ".json")
    fail(exit_bad_input,
         fmt::format("--features: '{}' ends neither in .csv nor in .json, so its format is unknown",
                     path));
  if (format == ".csv" && set.elements.empty())
    fail(exit_bad_input, fmt::format("--features: {} does not declare its elements, so a CSV file "
                                     "has no columns; .json takes it",
                                     set.name));
  file_.emplace(path);
  if (format == ".csv") {
    columns_.emplace(set);
    std::vector<std::string> header;
    for (const std::string& name : columns_->names) header.push_back(cell(name));
    file_->stream() << fmt::format("{}\n", fmt::join(header, ","));
  } else {
    file_->stream() << "[";
  }
}

void FeatureFile::add(const TickView& tick) {
  const Output* set = tick.output(0).output;
  if (set == nullptr) return;
  const double time = seconds(tick.time());
  const double acquired = seconds(set->acquired.oldest);
  if (columns_) {
    const std::string leading = fmt::format("{},{},{}", tick.tick(), time, acquired);
    for (const Estimate& element : set->elements) add_row(element, leading);
  } else {
    const Json json = {{"tick", tick.tick()},
                       {"time", time},
                       {"acquired", acquired},
                       {"output", outputs_json(tick)}};
    file_->stream() << (ticks_ == 0 ? "\n" : ",\n") << json_text(json, true);
  }
  ++ticks_;
}

void FeatureFile::add_row(const Estimate& element, const std::string& tick) {
  const auto type =
      std::find_if(columns_->types.begin(), columns_->types.end(),
                   [&](const Columns::Type& t) { return t.type->name == element.type->name; });
  if (type == columns_->types.end())
    fail(exit_failed, fmt::format("--features: the set holds {}, which its payload does not name",
                                  element.type->name));
  std::vector<std::string> cells(columns_->names.size() - leading_columns.size() + 2);
  const auto at = [&](std::size_t column) -> std::string& {
    return cells[column - leading_columns.size() + 2];
  };
  cells[0] = cell(element.frame);
  cells[1] = cell(element.type->name);
  for (std::size_t i = 0; i < type->labels.size(); ++i)
    at(type->labels[i]) =
        cell(element.type->labels[i].values[static_cast<std::size_t>(element.labels[i])]);
  for (std::size_t i = 0; i < type->components.size(); ++i)
    at(type->components[i]) = fmt::format("{}", element.value[i]);
  const Eigen::MatrixXd covariance = element.lineage.covariance();
  auto column = type->covariances.begin();
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    for (Eigen::Index j = i; j < covariance.cols(); ++j)
      at(*column++) = fmt::format("{}", covariance(i, j));
  file_->stream() << fmt::format("{},{}\n", tick, fmt::join(cells, ","));
}

void FeatureFile::commit() {
  if (!columns_) file_->stream() << "\n]\n";
  file_->commit();
}

}  // namespace ilss
