// The wall's line from the ranges of two sonars.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "framework/module/function_module.h"
#include "sensors/wall/wedge.h"

namespace ilss {

/// Which point of its beam a sonar is taken to touch the wall with.
enum class ContactAssumption { geometric, worst_case };
constexpr std::array<std::string_view, 2> choices(ContactAssumption) {
  return {"geometric", "worst_case"};
}

/// Function module: the two points p_i = mount_i + r_i (cos(heading_i + a_i), sin(heading_i + a_i))
/// where the sonars touch the wall (Henderson & Dekhil 1997, sec. 2.3). `worst_case` takes a_i =
/// beam half angle for both, as the paper does; `geometric` finds which of the nine combinations of
/// left edge, tangent and right edge gives both readings, and labels the points with it.
/// Faults: out_of_range for a range that is not positive or a beam half angle outside (0, 90 deg);
/// no_detection where no wall gives both readings; ambiguous, listing all, where several do;
/// degenerate where the sonars' places and axes leave the wall undetermined.
class WedgeSonarLine {
 public:
  static constexpr std::string_view name = "wedge_sonar_line";
  static constexpr std::string_view description = "wall line from the ranges of two sonars";
  static constexpr std::string_view reference = "Henderson & Dekhil 1997, sec. 2.3";
  static constexpr std::array<std::string_view, 2> inputs = {"left", "right"};
  static constexpr std::array faults = {FaultKind::out_of_range, FaultKind::no_detection,
                                        FaultKind::ambiguous, FaultKind::degenerate};

  struct Options {
    ContactAssumption contact = ContactAssumption::geometric;
    std::string frame = "robot";
    void declare(OptionVisitor& visit);
  };

  /// Both mounts must be given in one frame, the option `frame`.
  static void set_frames(Interface& interface, const Options& options);

  explicit WedgeSonarLine(const Options& options) : contact_(options.contact) {}

  /// The case is decided on the values alone; derivatives are those of its closed form.
  template <typename T>
  Outcome<WallPoints<T>> operator()(const SonarReading<T>& left,
                                    const SonarReading<T>& right) const {
    const auto solution = choose(values_of(left), values_of(right));
    if (!solution) return solution.fault();
    return wedge_points(left, right, *solution);
  }

 private:
  template <typename T>
  static SonarReading<double> values_of(const SonarReading<T>& sonar) {
    return {scalar_value(sonar.range), scalar_value(sonar.beam_half_angle),
            scalar_value(sonar.mount_x), scalar_value(sonar.mount_z),
            scalar_value(sonar.mount_heading)};
  }

  Outcome<WedgeSolution> choose(const SonarReading<double>& left,
                                const SonarReading<double>& right) const;

  ContactAssumption contact_;
};

}  // namespace ilss
