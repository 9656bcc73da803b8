#include "src/calibration_table.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "framework/estimate/units.h"
#include "framework/record/table.h"

namespace ilss {
namespace {

/// "depth" and "mm" of "depth [mm]"; no unit where there are no brackets.
struct Heading {
  std::string name;
  std::optional<std::string> unit;
};

Heading read_heading(const std::string& text) {
  const std::size_t open = text.find('[');
  if (open == std::string::npos || text.back() != ']') return {text, std::nullopt};
  const std::size_t end = text.find_last_not_of(" \t", open == 0 ? 0 : open - 1);
  return {text.substr(0, end + 1), text.substr(open + 1, text.size() - open - 2)};
}

/// A column of the file, and how its numbers become SI.
struct FoundColumn {
  std::size_t index = 0;
  UnitConversion conversion;
};

std::optional<FoundColumn> find_column(const Table& recording, const TableColumn& wanted,
                                       Position file, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  std::optional<FoundColumn> found;
  for (std::size_t i = 0; i < recording.columns.size(); ++i) {
    const Heading heading = read_heading(recording.columns[i]);
    names.push_back(heading.name);
    if (heading.name != wanted.name) continue;
    if (found) {
      diagnostics.add(file, fmt::format("a second column is named '{}'", wanted.name));
      return std::nullopt;
    }
    found = FoundColumn{i, {}};
    if (!heading.unit) {
      diagnostics.add(file,
                      fmt::format("column '{0}' needs its unit in brackets, as in '{0} [{1}]'",
                                  wanted.name, wanted.unit));
      return std::nullopt;
    }
    const auto conversion = unit_conversion(*heading.unit, wanted.unit);
    if (const auto* error = std::get_if<std::string>(&conversion)) {
      diagnostics.add(file, fmt::format("column '{}': {}", wanted.name, *error));
      return std::nullopt;
    }
    found->conversion = std::get<UnitConversion>(conversion);
  }
  if (!found && !wanted.optional)
    diagnostics.add(
        file, fmt::format("there is no column '{0}'; expected {1} under '{0} [{2}]'{3}{4} (the "
                          "columns are: {5})",
                          wanted.name, dimension_name(wanted.unit), wanted.unit,
                          wanted.hint.empty() ? "" : ", or ", wanted.hint, fmt::join(names, ", ")));
  return found;
}

void read_column(const Table& recording, const FoundColumn& column, const TableColumn& wanted,
                 std::vector<double>& numbers, Diagnostics& diagnostics) {
  numbers.reserve(recording.rows.size());
  for (const auto& row : recording.rows) {
    const TableCell& cell = row[column.index];
    const auto number = parse_quantity(cell.text, "1");
    const auto* value = std::get_if<double>(&number);
    const double si =
        value != nullptr ? column.conversion.scale * *value + column.conversion.offset : 0;
    if (value == nullptr || !std::isfinite(si))
      diagnostics.add(cell.position,
                      fmt::format("expected a number for '{}', got '{}'", wanted.name, cell.text));
    else if (wanted.positive && !(si > 0))
      diagnostics.add(cell.position,
                      fmt::format("'{}' must be positive, got {}", wanted.name, cell.text));
    numbers.push_back(si);
  }
}

}  // namespace

CalibrationTable read_calibration_table(const std::filesystem::path& path,
                                        std::span<const TableColumn> wanted,
                                        Diagnostics& diagnostics) {
  CalibrationTable table;
  const std::size_t errors = diagnostics.size();
  const Table recording = read_table(path, diagnostics);
  if (diagnostics.size() != errors) return table;
  Diagnostics none;
  const Position file{parse_document("", path.string(), none).position.file, 0, 0};
  if (recording.rows.empty()) diagnostics.add(file, "there is a header, but no rows");
  for (const TableColumn& column : wanted) {
    const auto found = find_column(recording, column, file, diagnostics);
    table.columns.emplace_back();
    if (found) read_column(recording, *found, column, table.columns.back(), diagnostics);
  }
  for (const auto& row : recording.rows) table.rows.push_back(row.front().position);
  return table;
}

}  // namespace ilss
