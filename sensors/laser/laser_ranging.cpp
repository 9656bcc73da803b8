#include "sensors/laser/laser_ranging.h"

#include <cmath>

namespace ilss {

void LaserRanging::Options::declare(OptionVisitor& visit) {
  visit("frame", frame, "name of the robot's frame, x forward and z to the right");
  visit("beam_width", beam_width, "within which a reading may hold two surfaces",
        {.unit = "m", .minimum = 0});
}

Interface LaserRanging::interface(const Options& options) {
  return {.inputs = {{"scan", &descriptor<LaserScan>()}},
          .output = &descriptor<RangeScan>(),
          .frame = options.frame};
}

Outcome<> LaserRanging::evaluate(const Evaluation& evaluation, Output& output) {
  const Output& scan = *evaluation.inputs[0];
  const auto device = payload_of<LaserScan>(scan.estimate);
  const auto p = payload_of<Parameters>(evaluation.parameters);
  if (!(p.scale > 0)) return Fault{FaultKind::out_of_range, "the scale must be above 0"};
  const double deviation =
      std::sqrt(device.range_std * device.range_std + device.quantum * device.quantum / 12);
  if (!(deviation > 0))
    return Fault{FaultKind::no_error_known, "the laser's ranges need a range_std or a quantum"};
  const std::span<const LaserBeam> beams = beams_of(scan);
  const std::span<RangeReading> readings = make_readings(output, beams.size());
  std::size_t count = 0;
  for (const LaserBeam& beam : beams) {
    const double range = p.scale * (beam.range - p.offset);
    if (beam.range == 0 || !(range > 0)) continue;
    const double u = 1 / range;
    readings[count++] = {scan.acquired,
                         0,
                         p.mount_x,
                         p.mount_z,
                         p.mount_heading - beam.bearing,
                         u,
                         u * u * p.scale * deviation,
                         {p.scale * u * u, -u}};
  }
  make_readings(output, count);
  if (count == 0) return Fault{FaultKind::no_detection, "no beam of the scan returned"};
  assign<RangeScan>(output.estimate, {p.mount_x, p.mount_z, p.mount_heading, 0, 0, 0, 0, 0, 0,
                                      options_.beam_width, 1});
  constexpr std::size_t scan_size = dimension_of<RangeScan>;
  std::array<double, scan_size * dimension_of<Parameters>> jacobian{};
  jacobian[0 * scan_size + 3] = 1;            // the offset, in m
  jacobian[1 * scan_size + 4] = 1 / p.scale;  // the scale's relative error
  for (std::size_t i = 0; i < 3; ++i) jacobian[(2 + i) * scan_size + i] = 1;
  const LineageTerm term{jacobian.data(), &evaluation.parameters.lineage};
  compose({&term, 1}, scan_size, output.estimate.lineage);
  return {};
}

}  // namespace ilss
