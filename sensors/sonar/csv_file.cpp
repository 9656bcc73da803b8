#include "sensors/sonar/csv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>

#include "framework/module/document.h"

namespace ilss {
namespace {

std::string_view trimmed(std::string_view cell) {
  constexpr std::string_view around = " \t\r\"";
  const std::size_t first = cell.find_first_not_of(around);
  if (first == std::string_view::npos) return {};
  return cell.substr(first, cell.find_last_not_of(around) - first + 1);
}

/// Calls `visit(cell)` for each cell until it returns false.
template <typename Visit>
void for_each_cell(std::string_view row, Visit visit) {
  for (;;) {
    const std::size_t comma = row.find(',');
    if (!visit(trimmed(row.substr(0, comma))) || comma == std::string_view::npos) return;
    row.remove_prefix(comma + 1);
  }
}

std::optional<double> parse_number(std::string_view cell) {
  double value = 0;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

Outcome<std::shared_ptr<const CsvFile>> CsvFile::open(const std::filesystem::path& path) {
  // Remembers only files that somebody still holds, so a file changed between runs is read anew.
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::weak_ptr<const CsvFile>> held;
  const std::lock_guard lock(mutex);
  if (auto file = held[path].lock()) return file;
  std::ifstream stream(path, std::ios::binary);
  std::string text;
  std::array<char, 65536> block;
  do {
    stream.read(block.data(), block.size());
    text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
  } while (stream);
  if (!stream.eof())
    return Fault{FaultKind::device_lost, fmt::format("cannot read '{}'", path.string())};
  std::shared_ptr<const CsvFile> file(new CsvFile(path, std::move(text)));
  held[path] = file;
  return file;
}

CsvFile::CsvFile(std::filesystem::path path, std::string text)
    : path_(std::move(path)), text_(std::move(text)) {
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text_.size();) {
    const std::size_t end = std::min(text_.find('\n', begin), text_.size());
    const Row row{begin, end, ++line};
    begin = end + 1;
    if (trimmed(text_of(row)).empty() || text_[row.begin] == '#') continue;
    rows_.push_back(row);
  }
  if (rows_.empty()) return;
  bool all_numbers = true;
  for_each_cell(text_of(rows_.front()), [&](std::string_view cell) {
    all_numbers &= parse_number(cell).has_value();
    header_.emplace_back(cell);
    return true;
  });
  if (all_numbers)
    header_.clear();
  else
    rows_.erase(rows_.begin());
}

Outcome<std::size_t> CsvFile::find_column(std::string_view name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found != header_.end()) return static_cast<std::size_t>(found - header_.begin());
  std::size_t number = 0;
  const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error == std::errc{} && stop == name.data() + name.size() && number >= 1) return number - 1;
  return Fault{FaultKind::bad_data,
               header_.empty()
                   ? fmt::format("'{}' has no header, so its columns have numbers (from 1), not "
                                 "names like '{}'",
                                 path_.string(), name)
                   : fmt::format("'{}' has no column '{}'{}", path_.string(), name,
                                 suggestion(name, header_))};
}

Outcome<double> CsvFile::number(std::size_t row, std::size_t column) const {
  std::optional<std::string_view> wanted;
  std::size_t count = 0;
  for_each_cell(text_of(rows_[row]), [&](std::string_view cell) {
    if (count++ != column) return true;
    wanted = cell;
    return false;
  });
  if (!wanted)
    return Fault{FaultKind::bad_data,
                 fmt::format("{}:{}: the row has {} columns, number {} is "
                             "wanted",
                             path_.string(), rows_[row].line, count, column + 1)};
  if (const auto value = parse_number(*wanted)) return *value;
  return Fault{FaultKind::bad_data,
               fmt::format("{}:{}: expected a number in column {}, got '{}'", path_.string(),
                           rows_[row].line, column + 1, *wanted)};
}

}  // namespace ilss
