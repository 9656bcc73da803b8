// Estimates and times as people read them: millimetres, degrees, aligned columns.
#pragma once

#include <string>

#include "framework/semantics/time_prediction.h"
#include "framework/semantics/verdict.h"

namespace ilss {

/// A unit for reading, and what SI values are multiplied by: metres are shown in mm, radians in
/// deg.
struct ReadingUnit {
  std::string name;
  double factor;
};
ReadingUnit reading_unit(const std::string& si_unit);

/// How many places after the point show two digits of a standard deviation; 3 where it is 0.
int decimal_places(double standard_deviation);

/// A number with so many places; one that rounds to 0 has no sign.
std::string decimal_text(double value, int places);

/// An error such as "1.25 mm", or a value with its standard deviation: "930.0 ± 1.2 mm".
std::string quantity_text(double value, const std::string& si_unit);
std::string quantity_text(double value, double standard_deviation, const std::string& si_unit);

/// Whether an output is samples or a set; exact ones among its components then only describe these.
bool has_parts(const PayloadDescriptor& payload);

/// A component's value with its standard deviation, or alone where it is exact: "119".
std::string exact_or_quantity_text(const Estimate& estimate, std::size_t component);

/// A component's standard deviation to second order.
double corrected_deviation(const Estimate& estimate, const VerdictReport& verdict,
                           std::size_t component);

/// Components with standard deviations, correlations, labels and the verdict, as lines.
std::string estimate_text(const Estimate& estimate, const VerdictReport& verdict);
/// The same of an element of a set, which no verdict is on.
std::string element_text(const Estimate& element);

/// Who is to blame for how much of each component's variance, largest share first.
std::string budget_text(const Estimate& estimate, const SourceOwners& owners);

/// "12.3 ms" or "340 ns".
std::string duration_text(double seconds);

/// The predicted time with its critical path and what it does not know.
std::string time_text(const TimePrediction& time, const Plan& plan);

}  // namespace ilss
