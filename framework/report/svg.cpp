#include "framework/report/svg.h"

#include <fmt/format.h>

#include "framework/report/estimate_text.h"

namespace ilss {
namespace {

/// Text as XML holds it; control characters, which it cannot hold, become blanks.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (static_cast<unsigned char>(c) < ' ')
      result += ' ';
    else
      result += c;
  }
  return result;
}

}  // namespace

std::string svg_number(double value) { return decimal_text(value, 2); }

SvgWriter::SvgWriter(double width, double height) {
  open("svg", {{"xmlns", "http://www.w3.org/2000/svg"},
               {"width", width},
               {"height", height},
               {"viewBox", fmt::format("0 0 {} {}", svg_number(width), svg_number(height))}});
}

void SvgWriter::begin(std::string_view name, SvgAttributes attributes) {
  text_ += fmt::format("<{}", name);
  for (const auto& [key, value] : attributes)
    text_ += fmt::format(" {}=\"{}\"", key, escaped(value.text()));
}

void SvgWriter::element(std::string_view name, SvgAttributes attributes) {
  begin(name, attributes);
  text_ += "/>\n";
}

void SvgWriter::element(std::string_view name, SvgAttributes attributes, std::string_view content) {
  begin(name, attributes);
  text_ += fmt::format(">{}</{}>\n", escaped(content), name);
}

void SvgWriter::open(std::string_view name, SvgAttributes attributes) {
  begin(name, attributes);
  text_ += ">\n";
  open_.emplace_back(name);
}

void SvgWriter::close() {
  text_ += fmt::format("</{}>\n", open_.back());
  open_.pop_back();
}

std::string SvgWriter::finish() && {
  while (!open_.empty()) close();
  return std::move(text_);
}

SvgPath& SvgPath::move_to(double x, double y) {
  text_ += fmt::format("M{} {}", svg_number(x), svg_number(y));
  return *this;
}

SvgPath& SvgPath::line_to(double x, double y) {
  text_ += fmt::format("L{} {}", svg_number(x), svg_number(y));
  return *this;
}

SvgPath& SvgPath::arc_to(double radius, bool clockwise, double x, double y) {
  text_ += fmt::format("A{0} {0} 0 0 {1} {2} {3}", svg_number(radius), clockwise ? 1 : 0,
                       svg_number(x), svg_number(y));
  return *this;
}

SvgPath& SvgPath::dot(double x, double y) {
  move_to(x, y);
  text_ += "h0";
  return *this;
}

}  // namespace ilss
