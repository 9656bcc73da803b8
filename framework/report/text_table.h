// Tables for people: columns as wide as their cells, groups of columns under a common heading.
#pragma once

#include <string>
#include <vector>

namespace ilss {

enum class Align { left, right };

/// A table of text. Cells are ASCII.
class TextTable {
 public:
  /// Adds a column; its heading may have several lines. Neighbouring columns of the same non-empty
  /// `group` stand under that word.
  void column(std::string heading, Align align = Align::right, std::string group = {});
  /// Adds a row; cells left out at the end are empty.
  void row(std::vector<std::string> cells);
  /// Adds a line across.
  void line();
  /// The table with a line below its headings.
  std::string text() const;

 private:
  struct Column {
    std::string heading;
    Align align;
    std::string group;
  };

  std::vector<std::size_t> widths() const;
  std::string group_headings(const std::vector<std::size_t>& widths) const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;  // an empty one is a line across
};

}  // namespace ilss
