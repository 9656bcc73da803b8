#include "framework/record/csv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>

#include "framework/module/document.h"
#include "framework/record/shown_text.h"

namespace ilss {
namespace {

/// Beyond this a line is no row of a recording, and the file probably no CSV.
constexpr std::size_t most_line_length = std::size_t{1} << 20;  // bytes

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

Fault lost(std::string message) { return {FaultKind::device_lost, std::move(message)}; }

Outcome<std::string> read_text(const std::filesystem::path& path) {
  const auto unreadable = [&](const std::error_code& error) {
    return lost(fmt::format("cannot read '{}': {}", path.string(), error.message()));
  };
  std::error_code error;
  const bool regular = std::filesystem::is_regular_file(path, error);
  if (error) return unreadable(error);
  // Opening a pipe would block the run, and a device may never end.
  if (!regular) return lost(fmt::format("'{}' is not a regular file", path.string()));
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return unreadable({errno, std::generic_category()});
  std::string text;
  std::string line(most_line_length + 1, '\0');
  std::size_t number = 1;
  for (; stream.getline(line.data(), static_cast<std::streamsize>(line.size())); ++number) {
    const auto taken = static_cast<std::size_t>(stream.gcount());  // counts the line's end, too
    text.append(line, 0, stream.eof() ? taken : taken - 1) += '\n';
  }
  if (stream.bad()) return unreadable({errno, std::generic_category()});
  if (!stream.eof())
    return lost(fmt::format("{}:{}: the line is longer than 1 MB; is this a CSV file?",
                            path.string(), number));
  if (text.find('\0') != std::string::npos)
    return lost(fmt::format("'{}' holds binary data; expected CSV text", path.string()));
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.starts_with(byte_order_mark)) text.erase(0, byte_order_mark.size());
  return text;
}

/// "front, left, back"; a header of very many columns is cut short.
std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t most = 50;
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), most));
  const std::string list = fmt::format("{}", fmt::join(names.begin(), end, ", "));
  return names.size() <= most ? list : fmt::format("{} and {} more", list, names.size() - most);
}

}  // namespace

Outcome<std::shared_ptr<const CsvFile>> CsvFile::open(const std::filesystem::path& path) {
  // Remembers only files that somebody still holds, so a file changed between runs is read anew.
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::weak_ptr<const CsvFile>> held;
  const std::lock_guard lock(mutex);
  if (auto file = held[path].lock()) return file;
  auto text = read_text(path);
  if (!text) return text.fault();
  std::shared_ptr<const CsvFile> file(new CsvFile(path, std::move(*text)));
  if (file->header_.size() == 1 && file->header_[0].find(';') != std::string::npos)
    return lost(
        fmt::format("the columns of '{}' are separated by ';'; expected ','", path.string()));
  if (file->rows_.empty())
    return lost(fmt::format("'{}' {}", path.string(),
                            file->header_.empty() ? "is empty" : "has a header, but no rows"));
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
  std::vector<std::string> first;
  bool names = false;
  for_each_cell(text_of(rows_.front()), [&](std::string_view cell) {
    names |= !cell.empty() && !parse_number(cell);
    first.emplace_back(cell);
    return true;
  });
  columns_ = first.size();
  if (!names) return;
  header_ = std::move(first);
  rows_.erase(rows_.begin());
}

Outcome<std::size_t> CsvFile::find_column(std::string_view name) const {
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found != header_.end()) return static_cast<std::size_t>(found - header_.begin());
  std::size_t number = 0;
  const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool is_number = error == std::errc{} && stop == name.data() + name.size();
  if (is_number && number >= 1 && number <= columns_) return number - 1;
  if (header_.empty())
    return lost(
        fmt::format("'{}' has no column '{}': without a header its columns have no names, "
                    "only the numbers 1 to {}",
                    path_.string(), name, columns_));
  return lost(fmt::format("'{}' has no column '{}' (its columns: {}){}", path_.string(), name,
                          list_of(header_), suggestion(name, header_)));
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
  if (wanted->empty())
    return Fault{FaultKind::no_detection, fmt::format("{}:{}: no echo: column {} is empty",
                                                      path_.string(), rows_[row].line, column + 1)};
  if (const auto value = parse_number(*wanted)) return *value;
  return Fault{FaultKind::bad_data,
               fmt::format("{}:{}: expected a number in column {}, got '{}'", path_.string(),
                           rows_[row].line, column + 1, shown(*wanted))};
}

std::string CsvFile::place(std::size_t row) const {
  return fmt::format("{}:{}", path_.string(), rows_[row].line);
}

}  // namespace ilss
