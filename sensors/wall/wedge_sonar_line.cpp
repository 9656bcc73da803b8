#include "sensors/wall/wedge_sonar_line.h"

#include <fmt/format.h>

#include <numbers>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

std::optional<Fault> check_sonar(const SonarReading<double>& sonar, std::string_view side) {
  if (!(sonar.range > 0) || !std::isfinite(sonar.range))
    return Fault{
        FaultKind::out_of_range,
        fmt::format("the {} sonar's range is {} m; it must be positive", side, sonar.range)};
  if (!(sonar.beam_half_angle > 0 && sonar.beam_half_angle < std::numbers::pi / 2))
    return Fault{FaultKind::out_of_range,
                 fmt::format("the {} sonar's beam half angle is {:.2f} deg; it must lie between 0 "
                             "and 90 deg",
                             side, sonar.beam_half_angle * degrees_per_radian)};
  if (!std::isfinite(sonar.mount_x + sonar.mount_z + sonar.mount_heading))
    return Fault{FaultKind::out_of_range, fmt::format("the {} sonar's mount is not finite", side)};
  return std::nullopt;
}

Fault no_wall(const SonarReading<double>& left, const SonarReading<double>& right) {
  return Fault{FaultKind::no_detection,
               fmt::format("no straight wall gives both ranges, left {:.1f} mm and right {:.1f} mm",
                           1e3 * left.range, 1e3 * right.range)};
}

Fault several_walls(const WedgeSolutions& solutions) {
  std::string list;
  for (const WedgeSolution& solution : solutions)
    list += (list.empty() ? "" : "; ") + describe(solution);
  return Fault{FaultKind::ambiguous,
               fmt::format("{} walls give both ranges: {}", solutions.size(), list)};
}

}  // namespace

void WedgeSonarLine::Options::declare(OptionVisitor& visit) {
  visit("contact", contact,
        "where the beams touch the wall: found from the geometry, or always on the right edge");
  visit("frame", frame, "the frame that both sonars' mounts are given in");
}

void WedgeSonarLine::set_frames(Interface& interface, const Options& options) {
  for (InputDeclaration& input : interface.inputs) input.frame = options.frame;
}

Outcome<WedgeSolution> WedgeSonarLine::choose(const SonarReading<double>& left,
                                              const SonarReading<double>& right) const {
  if (auto fault = check_sonar(left, "left")) return *std::move(fault);
  if (auto fault = check_sonar(right, "right")) return *std::move(fault);
  if (contact_ == ContactAssumption::worst_case)
    return WedgeSolution{Contact::right_edge, Contact::right_edge, 1, {}};
  const WedgeSolutions solutions = solve_wedge(left, right);
  if (solutions.undetermined)
    return Fault{FaultKind::degenerate,
                 "the sonars' places and axes leave the wall undetermined: more than one direction "
                 "of it gives the same two ranges"};
  if (solutions.empty()) return no_wall(left, right);
  if (solutions.size() > 1) return several_walls(solutions);
  return solutions[0];
}

}  // namespace ilss
