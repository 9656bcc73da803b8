// A table of comma-separated values whose cells know where they stand.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/document.h"

namespace ilss {

/// One cell of a table, without quotes and surrounding blanks.
struct TableCell {
  std::string text;
  Position position;
};

/// The cells of a CSV file: a row of column names, then rows of as many cells.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<TableCell>> rows;

  std::optional<std::size_t> find(std::string_view column) const;
};

/// Reads a CSV file. Empty lines and lines that start with '#' are left out; cells may be quoted. A
/// file that cannot be read, duplicate column names and rows of another length go to `diagnostics`.
Table read_table(const std::filesystem::path& path, Diagnostics& diagnostics);

}  // namespace ilss
