#include "framework/estimate/distribution.h"

#include <cmath>
#include <numbers>

namespace ilss {
namespace {

/// Of Student's t, with n degrees of freedom: a normal draw over the root of a chi-square one,
/// which is twice a gamma one (Marsaglia & Tsang 2000, "A simple method for generating gamma
/// variables"). @pre n > 2
double draw_student_t(double n, RandomBits& random) {
  const double normal = draw_normal(random);
  const double d = n / 2 - 1.0 / 3;
  const double c = 1 / std::sqrt(9 * d);
  while (true) {
    const double x = draw_normal(random);
    const double root = 1 + c * x;
    const double v = root * root * root;
    const double u = draw_unit(random);
    if (v > 0 && std::log(u) < x * x / 2 + d * (1 - v + std::log(v)))
      return normal * std::sqrt(n / (2 * d * v));
  }
}

/// The first coordinate of a point on the unit circle (arcsine law), without a sine: a point in the
/// disc at twice its angle (von Neumann 1951).
double draw_on_circle(RandomBits& random) {
  while (true) {
    const double x = draw_uniform(random, -1, 1);
    const double y = draw_uniform(random, -1, 1);
    const double square = x * x + y * y;
    if (square > 0 && square < 1) return (x * x - y * y) / square;
  }
}

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

double draw(const Distribution& distribution, RandomBits& random) {
  switch (distribution.shape) {
    case Shape::normal:
      return draw_normal(random);
    case Shape::uniform:
      return half_width(Shape::uniform) * (2 * draw_unit(random) - 1);
    case Shape::triangular:
      return half_width(Shape::triangular) * (draw_unit(random) - draw_unit(random));
    case Shape::arcsine:
      return half_width(Shape::arcsine) * draw_on_circle(random);
    case Shape::student_t: {
      const double n = distribution.degrees_of_freedom;
      return draw_student_t(n, random) / std::sqrt(n / (n - 2));
    }
    case Shape::empirical: {
      const auto& samples = *distribution.samples;
      return samples[draw_index(random, samples.size())];
    }
  }
  return 0;
}

}  // namespace ilss
