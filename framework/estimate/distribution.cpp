#include "framework/estimate/distribution.h"

#include <boost/random/normal_distribution.hpp>
#include <boost/random/student_t_distribution.hpp>
#include <cmath>
#include <numbers>

namespace ilss {
namespace {

/// In [0, 1).
double draw_unit(RandomBits& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

}  // namespace

std::string_view shape_name(Shape shape) {
  switch (shape) {
    case Shape::normal:
      return "normal";
    case Shape::uniform:
      return "uniform";
    case Shape::triangular:
      return "triangular";
    case Shape::arcsine:
      return "arcsine";
    case Shape::student_t:
      return "t";
    case Shape::empirical:
      return "empirical";
  }
  return "";
}

double half_width(Shape shape) {
  switch (shape) {
    case Shape::uniform:
      return std::sqrt(3.0);
    case Shape::triangular:
      return std::sqrt(6.0);
    case Shape::arcsine:
      return std::numbers::sqrt2;
    default:
      return 0;
  }
}

double draw_normal(RandomBits& random) {
  return boost::random::normal_distribution<double>()(random);
}

double draw(const Distribution& distribution, RandomBits& random) {
  switch (distribution.shape) {
    case Shape::normal:
      return draw_normal(random);
    case Shape::uniform:
      return half_width(Shape::uniform) * (2 * draw_unit(random) - 1);
    case Shape::triangular:
      return half_width(Shape::triangular) * (draw_unit(random) - draw_unit(random));
    case Shape::arcsine:
      return half_width(Shape::arcsine) * std::sin(std::numbers::pi * (draw_unit(random) - 0.5));
    case Shape::student_t: {
      const double n = distribution.degrees_of_freedom;
      return boost::random::student_t_distribution<double>(n)(random) / std::sqrt(n / (n - 2));
    }
    case Shape::empirical: {
      const auto& samples = *distribution.samples;
      const auto at =
          static_cast<std::size_t>(draw_unit(random) * static_cast<double>(samples.size()));
      return samples[at];
    }
  }
  return 0;
}

}  // namespace ilss
