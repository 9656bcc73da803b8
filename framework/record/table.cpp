#include "framework/record/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace ilss {
namespace {

/// The file as a whole; its name lives as long as that of a document does.
Position whole_file(const std::filesystem::path& path) {
  Diagnostics none;
  return {parse_document("", path.string(), none).position.file, 0, 0};
}

std::string_view trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// Where the cell that starts at `begin` ends: at the next comma outside quotes.
std::size_t end_of_cell(std::string_view line, std::size_t begin) {
  bool quoted = false;
  for (std::size_t i = begin; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == ',' && !quoted) return i;
  }
  return line.size();
}

/// A cell's text without its quotes; a doubled quote inside stands for one.
std::string unquote(std::string_view cell) {
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return std::string(cell);
  std::string text;
  for (std::size_t i = 1; i + 1 < cell.size(); ++i) {
    text += cell[i];
    if (cell[i] == '"' && cell[i + 1] == '"') ++i;
  }
  return text;
}

std::vector<TableCell> split_line(std::string_view line, Position position) {
  std::vector<TableCell> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = end_of_cell(line, begin);
    position.column = static_cast<int>(begin) + 1;
    cells.push_back({unquote(trim(line.substr(begin, end - begin))), position});
    begin = end + 1;
  }
  return cells;
}

void read_header(const std::vector<TableCell>& cells, Table& table, Diagnostics& diagnostics) {
  for (const TableCell& cell : cells) {
    if (table.find(cell.text))
      diagnostics.add(cell.position, fmt::format("a second column is named '{}'", cell.text));
    table.columns.push_back(cell.text);
  }
}

}  // namespace

std::optional<std::size_t> Table::find(std::string_view column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

Table read_table(const std::filesystem::path& path, Diagnostics& diagnostics) {
  Table table;
  Position position = whole_file(path);
  std::ifstream stream(path, std::ios::binary);
  std::error_code unknown;
  // A folder opens like a file, and throws when it is read.
  if (!stream || std::filesystem::is_directory(path, unknown)) {
    diagnostics.add(position, "the table cannot be read");
    return table;
  }
  const std::string text((std::istreambuf_iterator<char>(stream)),
                         std::istreambuf_iterator<char>());
  std::string_view rest = text;
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (rest.starts_with(byte_order_mark)) rest.remove_prefix(byte_order_mark.size());
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++position.line;
    if (trim(line).empty() || line.front() == '#') continue;
    std::vector<TableCell> cells = split_line(line, position);
    if (table.columns.empty())
      read_header(cells, table, diagnostics);
    else if (cells.size() != table.columns.size())
      diagnostics.add({position.file, position.line, 1},
                      fmt::format("a row of {} cells in a table of {} columns", cells.size(),
                                  table.columns.size()));
    else
      table.rows.push_back(std::move(cells));
  }
  if (table.columns.empty()) diagnostics.add(position, "the table is empty");
  return table;
}

}  // namespace ilss
