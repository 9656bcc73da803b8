#include "framework/record/feature_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "framework/estimate/decompositions.h"
#include "framework/module/document.h"
#include "framework/record/shown_text.h"

namespace ilss {
namespace {

using Json = nlohmann::json;

Fault bad(std::string message) { return {FaultKind::bad_data, std::move(message)}; }
Fault unreadable(std::string message) { return {FaultKind::device_lost, std::move(message)}; }

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

template <typename T>
std::optional<T> number_in(std::string_view text) {
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(value)) return std::nullopt;
  return value;
}

/// The cells of a row; one in quotes may hold commas, and quotes twice each.
std::vector<std::string> split(std::string_view row) {
  std::vector<std::string> cells;
  for (;;) {
    std::string cell;
    while (!row.empty() && (row.front() == ' ' || row.front() == '\t')) row.remove_prefix(1);
    const bool is_quoted = !row.empty() && row.front() == '"';
    if (is_quoted) {
      row.remove_prefix(1);
      for (; !row.empty() && (row.front() != '"' || row.substr(0, 2) == "\"\"");) {
        const std::size_t taken = row.front() == '"' ? 2 : 1;
        cell += row.front();
        row.remove_prefix(taken);
      }
    }
    const std::size_t comma = row.find(',');
    if (!is_quoted) cell = without_blanks(row.substr(0, comma));
    cells.push_back(std::move(cell));
    if (comma == std::string_view::npos) return cells;
    row.remove_prefix(comma + 1);
  }
}

/// A text as a cell: in quotes where it holds what would end it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

/// The type of that name among a set's elements. Fault: bad_data.
Outcome<const PayloadDescriptor*> find_type(std::string_view name, const PayloadDescriptor& set) {
  std::vector<std::string> names;
  for (const PayloadDescriptor* type : set.elements) {
    if (type->name == name) return type;
    names.push_back(type->name);
  }
  return bad(fmt::format("unknown type '{}'; expected {}{}", shown(name), set.element,
                         suggestion(name, names)));
}

Outcome<int> find_label(std::string_view value, const Label& label) {
  const auto found = std::find(label.values.begin(), label.values.end(), value);
  if (found == label.values.end())
    return bad(fmt::format("unknown {} '{}'; expected one of {}", label.name, shown(value),
                           fmt::join(label.values, ", ")));
  return static_cast<int>(found - label.values.begin());
}

/// A component's value, angles of circles wrapped. Fault: bad_data where one is more than a turn.
Outcome<double> checked_value(double value, const Component& component) {
  if (component.geometry == Geometry::plain) return value;
  if (!(std::abs(value) <= 2 * std::numbers::pi))
    return bad(fmt::format("{} is {} rad, more than a turn", component.name, value));
  return component.geometry == Geometry::circular ? wrap_angle(value) : value;
}

Outcome<RecordedTime> time_of(std::int64_t tick, double time, double acquired) {
  if (tick < 0) return bad(fmt::format("tick {}; expected 0 or more", tick));
  if (!(time >= acquired) || !std::isfinite(time - acquired))
    return bad(fmt::format("acquired at {} s, after the tick's time, {} s", acquired, time));
  return RecordedTime{tick, time - acquired};
}

}  // namespace

Outcome<Eigen::MatrixXd> covariance_factor(const Eigen::MatrixXd& covariance) {
  constexpr double tolerance = 1e-6;
  constexpr double largest = 1e200;  // of a variance, so that nothing overflows
  const Eigen::Index n = covariance.rows();
  Eigen::VectorXd deviation(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(covariance(i, i) >= 0 && covariance(i, i) <= largest))
      return bad(fmt::format("a variance of {}; expected 0 or more", covariance(i, i)));
    deviation[i] = std::sqrt(covariance(i, i));
  }
  Eigen::MatrixXd correlation = (deviation.array() > 0).cast<double>().matrix().asDiagonal();
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      if (covariance(i, j) == 0 && covariance(j, i) == 0) continue;
      const double below = covariance(i, j) / deviation[i] / deviation[j];
      const double above = covariance(j, i) / deviation[i] / deviation[j];
      if (!(std::abs(below) <= 1 + tolerance && std::abs(above) <= 1 + tolerance))
        return bad(fmt::format("a covariance of {} between standard deviations of {} and {}",
                               covariance(j, i), deviation[j], deviation[i]));
      if (!(std::abs(below - above) <= tolerance))
        return bad(fmt::format("the covariance is not symmetric: {} and {}", covariance(j, i),
                               covariance(i, j)));
      correlation(i, j) = correlation(j, i) = (below + above) / 2;
    }
  const auto eigen = symmetric_eigen(correlation);
  if (!(eigen.eigenvalues().minCoeff() >= -tolerance))
    return bad(
        fmt::format("the covariance is not positive semidefinite: its correlations have the "
                    "eigenvalue {:.3g}",
                    eigen.eigenvalues().minCoeff()));
  // Below rounding there is nothing but rounding.
  const double least = 1e-15 * static_cast<double>(n);
  const auto rank = static_cast<Eigen::Index>((eigen.eigenvalues().array() > least).count());
  return Eigen::MatrixXd(deviation.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
                         eigen.eigenvalues().tail(rank).cwiseSqrt().asDiagonal());
}

/// A row's cells, as many as the header's.
class FeatureColumns::Cells {
 public:
  static Outcome<Cells> read(std::string_view row, const std::vector<std::string>& names) {
    Cells cells{split(row), &names};
    if (cells.cells_.size() != names.size())
      return bad(fmt::format("the row has {} cells; expected {}, as the header has",
                             cells.cells_.size(), names.size()));
    return cells;
  }
  std::string_view text(std::size_t column) const { return cells_[column]; }
  bool is_empty(std::size_t column) const { return cells_[column].empty(); }
  /// Fault: bad_data where the cell is no finite number.
  Outcome<double> number(std::size_t column) const {
    if (const auto value = number_in<double>(cells_[column])) return *value;
    return bad(fmt::format("column {}: expected a number, got '{}'", (*names_)[column],
                           shown(cells_[column])));
  }

 private:
  Cells(std::vector<std::string> cells, const std::vector<std::string>* names)
      : cells_(std::move(cells)), names_(names) {}

  std::vector<std::string> cells_;
  const std::vector<std::string>* names_;
};

/// Finds where the parts of each type stand, labels of all types first.
void FeatureColumns::place_types(const PayloadDescriptor& set,
                                 const std::function<std::size_t(const std::string&)>& place) {
  for (const PayloadDescriptor* type : set.elements) types_.push_back({type, {}, {}, {}, {}});
  for (Type& type : types_)
    for (const Label& label : type.type->labels) type.labels.push_back(place(label.name));
  for (Type& type : types_)
    for (const Component& component : type.type->components)
      type.components.push_back(place(component.name));
  for (Type& type : types_) {
    const std::vector<Component>& parts = type.type->components;
    for (std::size_t i = 0; i < parts.size(); ++i)
      for (std::size_t j = i; j < parts.size(); ++j)
        type.covariances.push_back(
            place(fmt::format("covariance.{}.{}", parts[i].name, parts[j].name)));
  }
}

FeatureColumns::FeatureColumns(const PayloadDescriptor& set) {
  const auto place = [this](const std::string& name) {
    const auto column =
        static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
    if (column == names_.size()) names_.push_back(name);
    return column;
  };
  tick_ = place("tick");
  time_ = place("time");
  acquired_ = place("acquired");
  frame_ = place("frame");
  type_ = place("type");
  place_types(set, place);
}

std::string FeatureColumns::header() const {
  std::vector<std::string> cells;
  for (const std::string& name : names_) cells.push_back(cell(name));
  return fmt::format("{}\n", fmt::join(cells, ","));
}

std::string FeatureColumns::line(std::string_view leading, const Estimate& element) const {
  const auto type = std::find_if(types_.begin(), types_.end(),
                                 [&](const Type& t) { return t.type->name == element.type->name; });
  if (type == types_.end())
    throw std::invalid_argument(
        fmt::format("the set holds {}, which its payload does not name", element.type->name));
  std::vector<std::string> cells(names_.size());
  cells[frame_] = cell(element.frame);
  cells[type_] = cell(element.type->name);
  for (std::size_t i = 0; i < type->labels.size(); ++i)
    cells[type->labels[i]] =
        cell(element.type->labels[i].values[static_cast<std::size_t>(element.labels[i])]);
  for (std::size_t i = 0; i < type->components.size(); ++i)
    cells[type->components[i]] = fmt::format("{}", element.value[i]);
  const Eigen::MatrixXd covariance = element.lineage.covariance();
  auto column = type->covariances.begin();
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    for (Eigen::Index j = i; j < covariance.cols(); ++j)
      cells[*column++] = fmt::format("{}", covariance(i, j));
  return fmt::format("{},{}\n", leading, fmt::join(cells.begin() + 3, cells.end(), ","));
}

Outcome<FeatureColumns> FeatureColumns::read(std::string_view header,
                                             const PayloadDescriptor& set) {
  FeatureColumns columns;
  columns.names_ = split(header);
  const std::vector<std::string>& names = columns.names_;
  std::vector<bool> known(names.size(), false);
  const auto place = [&](const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return missing;
    const auto column = static_cast<std::size_t>(found - names.begin());
    known[column] = true;
    return column;
  };
  columns.tick_ = place("tick");
  columns.type_ = place("type");
  columns.time_ = place("time");
  columns.acquired_ = place("acquired");
  columns.frame_ = place("frame");
  if (columns.tick_ == missing || columns.type_ == missing)
    return unreadable(
        fmt::format("the header has no column '{}'; expected a CSV or JSON file of "
                    "features, as ilss run --features writes it",
                    columns.tick_ == missing ? "tick" : "type"));
  columns.place_types(set, place);
  for (Type& type : columns.types_) {
    type.has.assign(names.size(), false);
    for (const auto* list : {&type.labels, &type.components, &type.covariances})
      for (const std::size_t column : *list)
        if (column != missing) type.has[column] = true;
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto here = names.begin() + static_cast<std::ptrdiff_t>(i);
    const auto first = std::find(names.begin(), here, names[i]);
    if (first != here && known[static_cast<std::size_t>(first - names.begin())])
      return unreadable(fmt::format("the column '{}' comes twice", names[i]));
    if (names[i].starts_with("covariance.") && !known[i])
      return unreadable(fmt::format(
          "the column '{}' is of no two components of one type, in their order", shown(names[i])));
    // A column of the user's own may hold anything in every row.
    if (!known[i] || i == columns.tick_ || i == columns.type_ || i == columns.time_ ||
        i == columns.acquired_ || i == columns.frame_)
      for (Type& type : columns.types_) type.has[i] = true;
  }
  return columns;
}

std::optional<std::int64_t> FeatureColumns::tick_of(std::string_view row) const {
  const std::vector<std::string> cells = split(row);
  if (tick_ >= cells.size()) return std::nullopt;
  return number_in<std::int64_t>(cells[tick_]);
}

Outcome<FeatureColumns::Row> FeatureColumns::parse(std::string_view row,
                                                   std::string_view frame) const {
  const auto cells = Cells::read(row, names_);
  if (!cells) return cells.fault();
  const auto tick = number_in<std::int64_t>(cells->text(tick_));
  if (!tick)
    return bad(
        fmt::format("column tick: expected a whole number, got '{}'", shown(cells->text(tick_))));
  double time = 0;
  double acquired = 0;
  if (time_ != missing && acquired_ != missing) {
    const auto at = cells->number(time_);
    if (!at) return at.fault();
    const auto from = cells->number(acquired_);
    if (!from) return from.fault();
    time = *at;
    acquired = *from;
  }
  const auto when = time_of(*tick, time, acquired);
  if (!when) return when.fault();
  if (frame_ != missing && cells->text(frame_) != frame)
    return bad(fmt::format("in frame '{}'; expected '{}'", shown(cells->text(frame_)), frame));
  for (const Type& type : types_) {
    if (type.type->name != cells->text(type_)) continue;
    auto feature = read_feature(type, *cells);
    if (!feature) return feature.fault();
    return Row{*when, std::move(*feature)};
  }
  std::vector<std::string> names;
  for (const Type& type : types_) names.push_back(type.type->name);
  return bad(fmt::format("unknown type '{}'; expected one of {}{}", shown(cells->text(type_)),
                         fmt::join(names, ", "), suggestion(cells->text(type_), names)));
}

Outcome<RecordedFeature> FeatureColumns::read_feature(const Type& type, const Cells& cells) const {
  const PayloadDescriptor& payload = *type.type;
  for (std::size_t column = 0; column < names_.size(); ++column)
    if (!type.has[column] && !cells.is_empty(column))
      return bad(fmt::format("column {}: '{}', but {} has no such thing", names_[column],
                             shown(cells.text(column)), payload.name));
  const auto absent = [&](const std::string& name) {
    return bad(fmt::format("{} needs a column '{}'", payload.name, name));
  };
  RecordedFeature feature{.type = &payload};
  for (std::size_t i = 0; i < type.labels.size(); ++i) {
    if (type.labels[i] == missing) return absent(payload.labels[i].name);
    const auto label = find_label(cells.text(type.labels[i]), payload.labels[i]);
    if (!label) return label.fault();
    feature.labels.push_back(*label);
  }
  const std::size_t n = payload.components.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (type.components[i] == missing) return absent(payload.components[i].name);
    const auto number = cells.number(type.components[i]);
    if (!number) return number.fault();
    const auto value = checked_value(*number, payload.components[i]);
    if (!value) return value.fault();
    feature.value.push_back(*value);
  }
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size);
  auto column = type.covariances.begin();
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = i; j < size; ++j, ++column) {
      if (i != j && (*column == missing || cells.is_empty(*column))) continue;
      const std::string& name = payload.components[static_cast<std::size_t>(i)].name;
      if (*column == missing) return absent(fmt::format("covariance.{0}.{0}", name));
      const auto number = cells.number(*column);
      if (!number) return number.fault();
      covariance(i, j) = covariance(j, i) = *number;
    }
  auto factor = covariance_factor(covariance);
  if (!factor) return factor.fault();
  feature.factor = std::move(*factor);
  return feature;
}

namespace {

/// A member of a JSON object; null where there is none.
const Json& member(const Json& json, const char* name) {
  static const Json null;
  if (!json.is_object()) return null;
  const auto found = json.find(name);
  return found == json.end() ? null : *found;
}

std::string_view text_of(const Json& json) {
  return json.is_string() ? std::string_view(json.get_ref<const std::string&>())
                          : std::string_view();
}

/// For a message. What is nested is named only: it may be as deep as the file is long.
std::string shown_json(const Json& json) {
  return json.is_structured() ? fmt::format("an {}", json.type_name())
                              : shown(json.dump(-1, ' ', true));
}

Outcome<double> number_of(const Json& json, std::string_view what) {
  if (!json.is_number() || !std::isfinite(json.get<double>()))
    return bad(fmt::format("{}: expected a number, got {}", what, shown_json(json)));
  return json.get<double>();
}

Outcome<Eigen::MatrixXd> matrix_of(const Json& json, std::string_view what, std::size_t rows,
                                   std::size_t columns) {
  const auto wrong = [&] {
    return bad(fmt::format("{}: expected {} rows of {}", what, rows, columns));
  };
  if (!json.is_array() || json.size() != rows) return wrong();
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows; ++i) {
    if (!json[i].is_array() || json[i].size() != columns) return wrong();
    for (std::size_t j = 0; j < columns; ++j) {
      const auto number = number_of(json[i][j], what);
      if (!number) return number.fault();
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = *number;
    }
  }
  return matrix;
}

/// A number of a place or a column, from 0.
std::optional<std::uint32_t> index_of_json(const Json& json) {
  if (!json.is_number_unsigned() || json.get<std::uint64_t>() > UINT32_MAX) return std::nullopt;
  return json.get<std::uint32_t>();
}

Outcome<std::vector<RecordedSource>> sources_of(const Json& json) {
  std::vector<RecordedSource> sources;
  for (const Json& entry : json) {
    const auto column = index_of_json(member(entry, "column"));
    const std::string_view kind = text_of(member(entry, "kind"));
    const bool persistent = kind == "systematic";
    const Json& tick = member(entry, "tick");
    if (!persistent && kind != "random")
      return bad(fmt::format("source {}: unknown kind '{}'; expected random or systematic",
                             sources.size() + 1, shown(kind)));
    if (!member(entry, "owner").is_string() || !column ||
        !(persistent || (tick.is_number_integer() && tick.get<std::int64_t>() >= 0)))
      return bad(
          fmt::format("source {}: expected an owner, a column, a kind and, of a random "
                      "one, a tick",
                      sources.size() + 1));
    sources.push_back({std::string(text_of(entry["owner"])), *column,
                       persistent ? persistent_tick : tick.get<std::int64_t>()});
    if (std::find(sources.begin(), sources.end() - 1, sources.back()) != sources.end() - 1)
      return bad(fmt::format("source {}: the same as one before it", sources.size()));
  }
  return sources;
}

/// Reads the factor over so many common sources. Fault: bad_data, also where it gives another
/// covariance than `covariance`.
Outcome<> read_factor(const Json& json, std::size_t sources, const Eigen::MatrixXd& covariance,
                      RecordedFeature& feature) {
  constexpr double tolerance = 1e-6;  // of a correlation, as of a covariance
  constexpr double largest = 1e100;   // so that nothing overflows
  for (const Json& entry : member(json, "sources")) {
    const auto place = index_of_json(entry);
    if (!place || *place >= sources ||
        (!feature.sources.empty() && *place <= feature.sources.back()))
      return bad("factor: its sources are not places in the set's list, in their order");
    feature.sources.push_back(*place);
  }
  auto factor =
      matrix_of(member(json, "matrix"), "factor", feature.value.size(), feature.sources.size());
  if (!factor) return factor.fault();
  if (factor->size() > 0 && factor->cwiseAbs().maxCoeff() > largest)
    return bad("factor: a number is too large");
  const Eigen::MatrixXd squares = *factor * factor->transpose();
  const Eigen::VectorXd deviation = squares.diagonal().cwiseSqrt();
  if (((squares - covariance).array().abs() >
       tolerance * (deviation * deviation.transpose()).array())
          .any())
    return bad("the factor gives another covariance than the covariance");
  feature.factor = std::move(*factor);
  return {};
}

/// `sources` is how many the set's features have in common; nothing where the file does not tell.
Outcome<RecordedFeature> feature_of(const Json& json, const PayloadDescriptor& set,
                                    std::string_view frame, std::optional<std::size_t> sources) {
  const auto type = find_type(text_of(member(json, "type")), set);
  if (!type) return type.fault();
  const PayloadDescriptor& payload = **type;
  if (text_of(member(json, "frame")) != frame)
    return bad(
        fmt::format("in frame '{}'; expected '{}'", shown(text_of(member(json, "frame"))), frame));
  RecordedFeature feature{.type = &payload};
  for (const Label& label : payload.labels) {
    const auto value =
        find_label(text_of(member(member(json, "labels"), label.name.c_str())), label);
    if (!value) return value.fault();
    feature.labels.push_back(*value);
  }
  const Json& components = member(json, "components");
  if (!components.is_array() || components.size() != payload.components.size())
    return bad(
        fmt::format("expected the {} components of {}", payload.components.size(), payload.name));
  for (std::size_t i = 0; i < components.size(); ++i) {
    const Component& component = payload.components[i];
    if (text_of(member(components[i], "name")) != component.name)
      return bad(fmt::format("component {}: expected '{}', got '{}'", i + 1, component.name,
                             shown(text_of(member(components[i], "name")))));
    const auto number = number_of(member(components[i], "value"), component.name);
    if (!number) return number.fault();
    const auto value = checked_value(*number, component);
    if (!value) return value.fault();
    feature.value.push_back(*value);
  }
  const std::size_t n = payload.components.size();
  const auto covariance = matrix_of(member(json, "covariance"), "covariance", n, n);
  if (!covariance) return covariance.fault();
  if (sources) {
    if (auto read = read_factor(member(json, "factor"), *sources, *covariance, feature); !read)
      return read.fault();
    return feature;
  }
  auto factor = covariance_factor(*covariance);
  if (!factor) return factor.fault();
  feature.factor = std::move(*factor);
  return feature;
}

}  // namespace

Outcome<std::optional<RecordedSet>> parse_feature_json(std::string_view line,
                                                       const PayloadDescriptor& set,
                                                       std::string_view frame) {
  line = without_blanks(line);
  if (line.ends_with(',')) line.remove_suffix(1);
  if (line.empty() || line == "[" || line == "]") return std::optional<RecordedSet>();
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object())
    return bad(fmt::format("expected a tick's JSON object on a line, got '{}'", shown(line)));
  const Json& tick = member(json, "tick");
  if (!tick.is_number_integer())
    return bad(fmt::format("tick: expected a whole number, got {}", shown_json(tick)));
  const auto time = number_of(member(json, "time"), "time");
  if (!time) return time.fault();
  const auto acquired =
      number_of(json.contains("acquired") ? json["acquired"] : json["time"], "acquired");
  if (!acquired) return acquired.fault();
  const auto when = time_of(tick.get<std::int64_t>(), *time, *acquired);
  if (!when) return when.fault();
  const Json& output = member(json, "output");
  if (output.is_null() && json.contains("output")) return std::optional<RecordedSet>();
  if (text_of(member(output, "type")) != set.name)
    return bad(fmt::format("the output is '{}'; expected {}",
                           shown(text_of(member(output, "type"))), set.name));
  const Json& features = member(output, "features");
  if (!features.is_array()) return bad("features: expected a list");
  RecordedSet result{.time = *when};
  std::optional<std::size_t> source_count;
  if (const Json& sources = member(output, "sources"); sources.is_array()) {
    auto read = sources_of(sources);
    if (!read) return read.fault();
    result.sources = std::move(*read);
    source_count = result.sources.size();
  }
  for (std::size_t i = 0; i < features.size(); ++i) {
    auto feature = feature_of(features[i], set, frame, source_count);
    if (!feature) return bad(fmt::format("feature {}: {}", i + 1, feature.fault().message));
    result.features.push_back(std::move(*feature));
  }
  return std::optional(std::move(result));
}

}  // namespace ilss
