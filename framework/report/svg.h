// SVG as text: elements with attributes, numbers with fixed decimals, so that equal pictures are
// equal files.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ilss {

/// A number as SVG attributes hold it: two decimals, no sign of zero.
std::string svg_number(double value);

/// An attribute's value: text, or a number.
class SvgValue {
 public:
  SvgValue(double number) : text_(svg_number(number)) {}  // NOLINT(google-explicit-constructor)
  SvgValue(std::string text) : text_(std::move(text)) {}  // NOLINT(google-explicit-constructor)
  SvgValue(const char* text) : text_(text) {}             // NOLINT(google-explicit-constructor)
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};
using SvgAttributes = std::initializer_list<std::pair<std::string_view, SvgValue>>;

/// Writes one picture, an element a line.
class SvgWriter {
 public:
  /// A picture of so many pixels, as large as its view box.
  SvgWriter(double width, double height);

  /// An element without content, or with text.
  void element(std::string_view name, SvgAttributes attributes);
  void element(std::string_view name, SvgAttributes attributes, std::string_view content);
  /// An element with elements in it, up to `close`.
  void open(std::string_view name, SvgAttributes attributes);
  void close();

  /// The whole picture; all that is open is closed.
  std::string finish() &&;

 private:
  void begin(std::string_view name, SvgAttributes attributes);

  std::string text_;
  std::vector<std::string> open_;
};

/// The data of a path element; coordinates in pixels.
class SvgPath {
 public:
  SvgPath& move_to(double x, double y);
  SvgPath& line_to(double x, double y);
  /// Along a circle, the shorter way; `clockwise` as seen on the screen.
  SvgPath& arc_to(double radius, bool clockwise, double x, double y);
  /// A place to be drawn by the line's round end alone.
  SvgPath& dot(double x, double y);

  bool empty() const { return text_.empty(); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace ilss
