// The shape of an elementary error: what Monte Carlo draws, and how far a normal law holds for it.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "framework/estimate/random.h"

namespace ilss {

/// Laws of error (JCGM 101:2008, table 1).
enum class Shape { normal, uniform, triangular, arcsine, student_t, empirical };

/// The law of a source of error, scaled to zero mean and unit variance.
struct Distribution {
  Shape shape = Shape::normal;
  double degrees_of_freedom = 0;  ///< of a t distribution, above 2
  /// Of an empirical one: values of zero mean and unit variance, each as likely.
  std::shared_ptr<const std::vector<double>> samples = nullptr;
};

/// The name of a shape as users write it: "uniform", "t".
std::string_view shape_name(Shape shape);

/// What the half width of a bounded law is in standard deviations; 0 where it has none.
double half_width(Shape shape);

/// One draw of zero mean and unit variance; the same wherever the program is built (random.h).
double draw(const Distribution& distribution, RandomBits& random);

}  // namespace ilss
