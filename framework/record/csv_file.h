// A recording as comma-separated values: read once, shared by the sensors that play it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/outcome.h"

namespace ilss {

/// The cells of a CSV file, with at least one row. Empty lines and lines that start with '#' are
/// left out; a first row with a cell that is neither a number nor empty is the header.
class CsvFile {
 public:
  /// Faults: device_lost where there is no regular file that can be read, it is binary, a line is
  /// longer than 1 MB, there are no rows, or the header's columns are separated by ';'.
  static Outcome<std::shared_ptr<const CsvFile>> open(const std::filesystem::path& path);

  std::size_t rows() const { return rows_.size(); }

  /// A column by its name in the header, or by its number, counted from 1. Faults: device_lost
  /// where the header (without one: the first row) has no such column.
  Outcome<std::size_t> find_column(std::string_view name) const;

  /// The number in a row and column, counted from 0. Faults, with file and line: no_detection where
  /// the cell is empty; bad_data where the row is short or the cell is no finite number.
  Outcome<double> number(std::size_t row, std::size_t column) const;

  /// "file:line" of a row, for messages.
  std::string place(std::size_t row) const;

 private:
  struct Row {
    std::size_t begin;
    std::size_t end;
    std::size_t line;
  };

  CsvFile(std::filesystem::path path, std::string text);
  std::string_view text_of(const Row& row) const {
    return std::string_view(text_).substr(row.begin, row.end - row.begin);
  }

  std::filesystem::path path_;
  std::string text_;
  std::vector<std::string> header_;  ///< empty where the file has none
  std::size_t columns_ = 0;          ///< of the header or, without one, the first row
  std::vector<Row> rows_;
};

}  // namespace ilss
