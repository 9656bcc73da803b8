#include "framework/report/text_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace ilss {
namespace {

constexpr std::size_t gap = 2;
constexpr std::size_t group_gap = 3;

std::string trim_end(std::string text) {
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  return lines;
}

}  // namespace

void TextTable::column(std::string heading, Align align, std::string group) {
  columns_.push_back({std::move(heading), align, std::move(group)});
}

void TextTable::row(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

void TextTable::line() { rows_.emplace_back(); }

std::vector<std::size_t> TextTable::widths() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t width = 0;
    for (const std::string& line : split_lines(columns_[c].heading))
      width = std::max(width, line.size());
    for (const auto& cells : rows_)
      if (!cells.empty()) width = std::max(width, cells[c].size());
    // The space before a column is part of it; more where a group begins.
    if (c > 0) width += columns_[c].group == columns_[c - 1].group ? gap : group_gap;
    widths.push_back(width);
  }
  return widths;
}

std::string TextTable::group_headings(const std::vector<std::size_t>& widths) const {
  std::string headings;
  std::size_t at = 0;
  for (std::size_t c = 0; c < columns_.size(); at += widths[c], ++c) {
    if (c > 0 && columns_[c].group == columns_[c - 1].group) continue;
    const std::size_t begin = at + (c > 0 ? group_gap : 0);
    headings.resize(std::max(headings.size() + (headings.empty() ? 0 : 1), begin), ' ');
    headings += columns_[c].group;
  }
  headings = trim_end(std::move(headings));
  return headings.empty() ? headings : headings + "\n";
}

std::string TextTable::text() const {
  const std::vector<std::size_t> width = widths();
  std::size_t total = 0;
  for (const std::size_t w : width) total += w;
  const std::string across = std::string(total, '-') + "\n";
  const auto line_of = [&](const auto& cell_of) {
    std::string line;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const std::string cell = cell_of(c);
      const std::size_t before = c == 0                                       ? 0
                                 : columns_[c].group == columns_[c - 1].group ? gap
                                                                              : group_gap;
      if (columns_[c].align == Align::right)
        line += fmt::format("{:>{}}", cell, width[c]);
      else
        line += std::string(before, ' ') + fmt::format("{:<{}}", cell, width[c] - before);
    }
    return trim_end(std::move(line)) + "\n";
  };
  std::string text = group_headings(width);
  // Headings of fewer lines than others stand at the top.
  std::size_t heading_lines = 1;
  for (const Column& column : columns_)
    heading_lines = std::max(heading_lines, split_lines(column.heading).size());
  for (std::size_t h = 0; h < heading_lines; ++h)
    text += line_of([&](std::size_t c) {
      const std::vector<std::string> lines = split_lines(columns_[c].heading);
      return h < lines.size() ? lines[h] : std::string();
    });
  text += across;
  for (const auto& cells : rows_)
    text += cells.empty() ? across : line_of([&](std::size_t c) { return cells[c]; });
  return text;
}

}  // namespace ilss
