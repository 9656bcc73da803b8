#include "framework/report/picture_svg.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include "framework/report/error_ellipse.h"
#include "framework/report/estimate_text.h"
#include "framework/report/svg.h"

namespace ilss {
namespace {

using Eigen::Vector2d;
using Box = Eigen::AlignedBox2d;

// Pixels.
constexpr double largest_width = 640;
constexpr double largest_height = 600;
constexpr double least_total_width = 520;
constexpr double left_margin = 58;
constexpr double right_margin = 20;
constexpr double title_height = 20;
constexpr double axis_height = 46;
constexpr double legend_height = 19;
constexpr double reading_size = 2.6;
constexpr double least_visible_error = 1;
constexpr double least_half_axis = 0.1;  // a flatter ellipse would not be drawn at all

constexpr double probability = 0.95;
constexpr double least_extent = 0.1;  // m
constexpr double margin = 0.06;       // of the extent

/// Colours of the modules, each with a contrast of at least 3 to white and to black.
constexpr std::array<const char*, 6> colours = {"#2f80d0", "#e0641e", "#2a9d62",
                                                "#a05bd0", "#d04a74", "#8f7d1f"};
constexpr const char* grey = "#868686";

/// What of a picture must be seen: everything but the scenes, and readings far beyond the others.
Box extent_of(const Picture& picture) {
  Box box;
  for (const PictureLayer& layer : picture.layers) {
    if (const auto& field = layer.field) {
      for (const Vector2d& point : {field->origin, field->first, field->last}) box.extend(point);
      for (const PictureReading& reading : layer.readings)
        if ((reading.at - field->origin).norm() <= field->far) box.extend(reading.at);
    }
    for (const PictureStroke& stroke : layer.strokes) {
      box.extend(stroke.from.at);
      box.extend(stroke.to.at);
    }
    for (const PictureMark& mark : layer.marks) box.extend(mark.point.at);
  }
  const Vector2d missing = (Vector2d::Constant(least_extent) - box.sizes()).cwiseMax(0.0);
  const Vector2d border = missing / 2 + Vector2d::Constant(margin * box.sizes().maxCoeff());
  return {box.min() - border, box.max() + border};
}

/// A round distance between grid lines (m): 1, 2 or 5 times a power of ten, at least `least`.
double grid_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least) return factor * power;
  return 10 * power;
}

/// Text in lines of at most so many characters, broken at blanks.
std::vector<std::string> wrapped(const std::string& text, std::size_t most) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (lines.empty() || lines.back().size() + 1 + word.size() > most)
      lines.push_back(word);
    else
      lines.back() += " " + word;
  }
  return lines;
}

/// Draws one picture.
class Drawing {
 public:
  Drawing(const Picture& picture, double error_scale)
      : picture_(picture),
        error_scale_(error_scale),
        extent_(extent_of(picture)),
        pixels_per_metre_(
            std::min(largest_width / extent_.sizes().x(), largest_height / extent_.sizes().y())),
        plot_size_(extent_.sizes() * pixels_per_metre_),
        width_(std::max(least_total_width, left_margin + plot_size_.x() + right_margin)) {
    constexpr double title_letter = 9.6;
    title_ = wrapped(picture.title, static_cast<std::size_t>((width_ - 20) / title_letter));
    top_ = title_height * static_cast<double>(title_.size() + 1) + 16;
  }

  std::string text() && {
    legend_ = legend();
    const double bottom = top_ + plot_size_.y() + axis_height;
    const double height = bottom + legend_height * static_cast<double>(legend_.size()) + 8;
    SvgWriter svg(width_, height);
    svg.open("g", {{"font-family", "sans-serif"}, {"font-size", "12"}, {"fill", grey}});
    write_title(svg);
    write_grid(svg);
    write_legend(svg, bottom);
    svg.close();
    // A picture in the picture, which cuts off what is outside.
    svg.open("svg", {{"x", left_margin},
                     {"y", top_},
                     {"width", plot_size_.x()},
                     {"height", plot_size_.y()},
                     {"fill", "none"}});
    for (const PictureScene& scene : picture_.scenes) write_scene(svg, scene);
    for (std::size_t i = 0; i < picture_.layers.size(); ++i)
      write_layer(svg, picture_.layers[i], colour(i));
    return std::move(svg).finish();
  }

 private:
  /// A line of the legend: what it shows, in which colour.
  enum class Sample { readings, stroke, mark, scene, none };
  struct LegendLine {
    Sample sample;
    const char* colour;
    std::string text;
  };

  static const char* colour(std::size_t layer) { return colours[layer % colours.size()]; }

  /// Where a place is in the plot (px).
  Vector2d pixel(const Vector2d& place) const {
    return {(place.x() - extent_.min().x()) * pixels_per_metre_,
            (extent_.max().y() - place.y()) * pixels_per_metre_};
  }

  std::vector<LegendLine> legend() const {
    std::vector<LegendLine> lines;
    std::string errors;
    for (std::size_t i = 0; i < picture_.layers.size(); ++i) {
      const PictureLayer& layer = picture_.layers[i];
      const bool is_scan = !layer.readings.empty();
      const Sample sample = is_scan                  ? Sample::readings
                            : !layer.strokes.empty() ? Sample::stroke
                                                     : Sample::mark;
      lines.push_back({sample, colour(i), fmt::format("{}: {}", layer.module, layer.content)});
      const std::string meaning = is_scan ? "bars of readings are ±1 std" : "ellipses hold 95 %";
      if (errors.find(meaning) == std::string::npos)
        errors += (errors.empty() ? "" : ", ") + meaning;
    }
    for (const PictureScene& scene : picture_.scenes)
      lines.push_back(
          {Sample::scene, grey, fmt::format("the scene that {} looks at", scene.module)});
    if (error_scale_ != 1)
      errors += fmt::format("; errors drawn {:g} times as large", error_scale_);
    lines.push_back({Sample::none, grey, errors});
    return lines;
  }

  void write_title(SvgWriter& svg) const {
    double y = title_height;
    for (const std::string& line : title_) {
      svg.element("text", {{"x", 12.0}, {"y", y}, {"font-size", "15"}, {"font-weight", "bold"}},
                  line);
      y += title_height;
    }
    svg.element("text", {{"x", 12.0}, {"y", y}}, picture_.subtitle);
  }

  void write_grid(SvgWriter& svg) const {
    constexpr double least_spacing = 64;
    const double step = grid_step(least_spacing / pixels_per_metre_);
    const int places = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
    const double bottom = top_ + plot_size_.y();
    SvgPath lines;
    const auto for_each_line = [&](int axis, const auto& visit) {
      const auto first = static_cast<std::int64_t>(std::ceil(extent_.min()[axis] / step));
      const auto last = static_cast<std::int64_t>(std::floor(extent_.max()[axis] / step));
      for (std::int64_t k = first; k <= last; ++k) visit(static_cast<double>(k) * step);
    };
    for_each_line(0, [&](double value) {
      const double x = left_margin + (value - extent_.min().x()) * pixels_per_metre_;
      lines.move_to(x, top_).line_to(x, bottom);
      svg.element("text", {{"x", x}, {"y", bottom + 16}, {"text-anchor", "middle"}},
                  decimal_text(picture_.axes.right_sign * value, places));
    });
    for_each_line(1, [&](double value) {
      const double y = top_ + (extent_.max().y() - value) * pixels_per_metre_;
      lines.move_to(left_margin, y).line_to(left_margin + plot_size_.x(), y);
      svg.element("text", {{"x", left_margin - 6}, {"y", y + 4}, {"text-anchor", "end"}},
                  decimal_text(value, places));
    });
    svg.element("path", {{"class", "grid"},
                         {"d", lines.text()},
                         {"stroke", grey},
                         {"stroke-opacity", "0.25"},
                         {"fill", "none"}});
    svg.element("rect", {{"x", left_margin},
                         {"y", top_},
                         {"width", plot_size_.x()},
                         {"height", plot_size_.y()},
                         {"stroke", grey},
                         {"stroke-opacity", "0.6"},
                         {"fill", "none"}});
    svg.element(
        "text",
        {{"x", left_margin + plot_size_.x() / 2}, {"y", bottom + 34}, {"text-anchor", "middle"}},
        picture_.axes.right + " (m)");
    const double middle = top_ + plot_size_.y() / 2;
    svg.element("text",
                {{"x", 16.0},
                 {"y", middle},
                 {"text-anchor", "middle"},
                 {"transform", fmt::format("rotate(-90 16 {})", svg_number(middle))}},
                picture_.axes.up + " (m)");
  }

  void write_legend(SvgWriter& svg, double y) const {
    for (const LegendLine& line : legend_) {
      y += legend_height;
      const double middle = y - 4;
      SvgPath sample;
      switch (line.sample) {
        case Sample::readings:
          sample.dot(16, middle).dot(24, middle).dot(32, middle);
          svg.element("path", {{"d", sample.text()},
                               {"stroke", line.colour},
                               {"stroke-width", reading_size},
                               {"stroke-linecap", "round"}});
          break;
        case Sample::stroke:
        case Sample::scene:
          sample.move_to(13, middle).line_to(35, middle);
          svg.element("path", {{"d", sample.text()},
                               {"stroke", line.colour},
                               {"stroke-width", line.sample == Sample::stroke ? 1.6 : 1.0}});
          break;
        case Sample::mark:
          svg.element("circle", {{"cx", 24.0},
                                 {"cy", middle},
                                 {"r", 5.0},
                                 {"stroke", line.colour},
                                 {"stroke-width", 1.5},
                                 {"fill", "none"}});
          break;
        case Sample::none:
          break;
      }
      svg.element("text", {{"x", 44.0}, {"y", y}}, line.text);
    }
  }

  void write_scene(SvgWriter& svg, const PictureScene& scene) const {
    svg.open("g", {{"class", "scene"}, {"stroke", grey}, {"stroke-width", "1"}});
    for (const auto& [from, to] : scene.walls) {
      const Vector2d a = pixel(from);
      const Vector2d b = pixel(to);
      svg.element("line", {{"x1", a.x()}, {"y1", a.y()}, {"x2", b.x()}, {"y2", b.y()}});
    }
    for (const PictureScene::Pillar& pillar : scene.pillars) {
      const Vector2d centre = pixel(pillar.centre);
      svg.element(
          "circle",
          {{"cx", centre.x()}, {"cy", centre.y()}, {"r", pillar.radius * pixels_per_metre_}});
    }
    svg.close();
  }

  void write_layer(SvgWriter& svg, const PictureLayer& layer, const char* layer_colour) const {
    svg.open("g", {{"class", "module"}, {"stroke", layer_colour}, {"stroke-width", "1.6"}});
    if (layer.field) write_field(svg, *layer.field);
    if (!layer.readings.empty()) write_readings(svg, layer.readings);
    for (const PictureStroke& stroke : layer.strokes) {
      write_ellipse(svg, stroke.from, layer_colour);
      write_ellipse(svg, stroke.to, layer_colour);
    }
    for (const PictureMark& mark : layer.marks) write_ellipse(svg, mark.point, layer_colour);
    for (const PictureStroke& stroke : layer.strokes) write_stroke(svg, stroke);
    for (const PictureMark& mark : layer.marks) write_mark(svg, mark);
    svg.close();
  }

  void write_field(SvgWriter& svg, const PictureField& field) const {
    const Vector2d origin = pixel(field.origin);
    const Vector2d first = pixel(field.first);
    const Vector2d last = pixel(field.last);
    SvgPath rays;
    rays.move_to(first.x(), first.y()).line_to(origin.x(), origin.y()).line_to(last.x(), last.y());
    svg.element("path", {{"class", "field"},
                         {"d", rays.text()},
                         {"stroke-width", "1"},
                         {"stroke-opacity", "0.6"},
                         {"stroke-dasharray", "4 4"}});
    svg.element("circle", {{"class", "sensor"},
                           {"cx", origin.x()},
                           {"cy", origin.y()},
                           {"r", 4.0},
                           {"stroke-width", "1.5"}});
  }

  void write_readings(SvgWriter& svg, const std::vector<PictureReading>& readings) const {
    SvgPath dots;
    SvgPath bars;
    for (const PictureReading& reading : readings) {
      const Vector2d at = pixel(reading.at);
      if (!Box(Vector2d::Zero(), plot_size_).contains(at)) continue;
      dots.dot(at.x(), at.y());
      const Vector2d deviation = error_scale_ * reading.deviation;
      const double length = deviation.norm() * pixels_per_metre_;
      if (!(length > reading_size / 2 && std::isfinite(length))) continue;
      const Vector2d near = pixel(reading.at - deviation);
      const Vector2d far = pixel(reading.at + deviation);
      bars.move_to(near.x(), near.y()).line_to(far.x(), far.y());
    }
    if (!bars.empty())
      svg.element("path", {{"class", "deviations"},
                           {"d", bars.text()},
                           {"stroke-width", "1"},
                           {"stroke-opacity", "0.3"}});
    svg.element("path", {{"class", "readings"},
                         {"d", dots.text()},
                         {"stroke-width", reading_size},
                         {"stroke-linecap", "round"}});
  }

  void write_ellipse(SvgWriter& svg, const UncertainPoint& point, const char* fill) const {
    const ErrorEllipse ellipse = error_ellipse(point.covariance, probability);
    const double scale = error_scale_ * pixels_per_metre_;
    if (!(ellipse.major * scale >= least_visible_error && std::isfinite(ellipse.major))) return;
    const Vector2d at = pixel(point.at);
    // The screen's angles run clockwise.
    const double degrees = -ellipse.angle * 180 / std::numbers::pi;
    svg.element("ellipse", {{"cx", at.x()},
                            {"cy", at.y()},
                            {"rx", ellipse.major * scale},
                            {"ry", std::max(ellipse.minor * scale, least_half_axis)},
                            {"transform", fmt::format("rotate({} {} {})", svg_number(degrees),
                                                      svg_number(at.x()), svg_number(at.y()))},
                            {"stroke-width", "1"},
                            {"fill", fill},
                            {"fill-opacity", "0.2"}});
  }

  void write_stroke(SvgWriter& svg, const PictureStroke& stroke) const {
    const Vector2d from = pixel(stroke.from.at);
    const Vector2d to = pixel(stroke.to.at);
    SvgPath path;
    path.move_to(from.x(), from.y());
    if (stroke.centre) {
      const Vector2d centre = pixel(*stroke.centre);
      const Vector2d a = from - centre;
      const Vector2d b = to - centre;
      path.arc_to(a.norm(), a.x() * b.y() - a.y() * b.x() > 0, to.x(), to.y());
    } else {
      path.line_to(to.x(), to.y());
    }
    svg.open("path", {{"class", "stroke"}, {"d", path.text()}});
    svg.element("title", {}, stroke.text);
    svg.close();
    // Short lines across its ends, so that pieces of one line are told apart.
    constexpr double half_length = 5;
    const Vector2d along = to - from;
    SvgPath ends;
    for (const Vector2d& end : {from, to}) {
      const Vector2d normal =
          stroke.centre ? Vector2d(end - pixel(*stroke.centre)) : Vector2d(-along.y(), along.x());
      const Vector2d across = half_length * normal.normalized();
      ends.move_to(end.x() - across.x(), end.y() - across.y())
          .line_to(end.x() + across.x(), end.y() + across.y());
    }
    svg.element("path", {{"class", "ends"}, {"d", ends.text()}, {"stroke-width", "1.5"}});
  }

  void write_mark(SvgWriter& svg, const PictureMark& mark) const {
    constexpr double size = 6;
    const Vector2d at = pixel(mark.point.at);
    if (mark.is_jump) {
      SvgPath cross;
      cross.move_to(at.x() - size, at.y() - size).line_to(at.x() + size, at.y() + size);
      cross.move_to(at.x() - size, at.y() + size).line_to(at.x() + size, at.y() - size);
      svg.open("path", {{"class", "jump"}, {"d", cross.text()}, {"stroke-width", "1.5"}});
    } else {
      svg.open("circle", {{"class", "place"},
                          {"cx", at.x()},
                          {"cy", at.y()},
                          {"r", size},
                          {"stroke-width", "1.5"}});
    }
    svg.element("title", {}, mark.text);
    svg.close();
  }

  const Picture& picture_;
  double error_scale_;
  Box extent_;
  double pixels_per_metre_;
  Vector2d plot_size_;
  double width_;
  double top_ = 0;
  std::vector<std::string> title_;
  std::vector<LegendLine> legend_;
};

}  // namespace

std::string picture_svg(const Picture& picture, double error_scale) {
  return Drawing(picture, error_scale).text();
}

}  // namespace ilss
