#include "framework/graph/recording.h"

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

std::vector<RecordedCell> split_line(std::string_view line, Position position) {
  std::vector<RecordedCell> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = end_of_cell(line, begin);
    position.column = static_cast<int>(begin) + 1;
    cells.push_back({unquote(trim(line.substr(begin, end - begin))), position});
    begin = end + 1;
  }
  return cells;
}

void read_header(const std::vector<RecordedCell>& cells, Recording& recording,
                 Diagnostics& diagnostics) {
  for (const RecordedCell& cell : cells) {
    if (recording.find(cell.text))
      diagnostics.add(cell.position, fmt::format("a second column is named '{}'", cell.text));
    recording.columns.push_back(cell.text);
  }
}

}  // namespace

std::optional<std::size_t> Recording::find(std::string_view column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

Recording read_recording(const std::filesystem::path& path, Diagnostics& diagnostics) {
  Recording recording;
  Position position = whole_file(path);
  std::ifstream stream(path, std::ios::binary);
  std::error_code unknown;
  // A folder opens like a file, and throws when it is read.
  if (!stream || std::filesystem::is_directory(path, unknown)) {
    diagnostics.add(position, "the recording cannot be read");
    return recording;
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
    std::vector<RecordedCell> cells = split_line(line, position);
    if (recording.columns.empty())
      read_header(cells, recording, diagnostics);
    else if (cells.size() != recording.columns.size())
      diagnostics.add({position.file, position.line, 1},
                      fmt::format("a row of {} cells in a recording of {} columns", cells.size(),
                                  recording.columns.size()));
    else
      recording.rows.push_back(std::move(cells));
  }
  if (recording.columns.empty()) diagnostics.add(position, "the recording is empty");
  return recording;
}

}  // namespace ilss
