#include "sensors/lep/lep_ranging.h"

#include <cmath>
#include <numbers>

namespace ilss {
namespace {

constexpr std::size_t scan_size = dimension_of<RangeScan>;
constexpr std::size_t parameter_count = dimension_of<LepRanging::Parameters>;

/// An inverse range and what it depends on.
struct InverseRange {
  double value;                                         ///< u (1/m)
  double by_position;                                   ///< du/dp (1/m²)
  std::array<double, shared_range_errors> sensitivity;  ///< as LepRanging says
};

/// u = (p + f tan gamma) / (p A + f B) (eq. 6, see LepRay), and its exact derivatives.
class RangeEquation {
 public:
  explicit RangeEquation(const LepGeometry<double>& geometry)
      : geometry_(geometry),
        tangent_(std::tan(geometry.vergence)),
        secant_(1 / std::cos(geometry.vergence)) {}

  InverseRange operator()(double p, double c, double s) const {
    const double f = geometry_.focal_length;
    const double d = geometry_.baseline;
    const double a_by_d = s - c * tangent_;
    const double b_by_d = c + s * tangent_;
    const double a = d * a_by_d - geometry_.lens_distance * secant_;
    const double b = d * b_by_d;
    const double scale = 1 / (p * a + f * b);
    const double u = (p + f * tangent_) * scale;
    const double slope = secant_ * secant_;  // of tan gamma
    const double a_by_gamma = -d * c * slope - geometry_.lens_distance * secant_ * tangent_;
    const double b_by_gamma = d * s * slope;
    const double a_by_angle = d * (c + s * tangent_);
    const double b_by_angle = d * (-s + c * tangent_);
    return {u,
            (1 - u * a) * scale,
            {f * (tangent_ - u * b) * scale, -u * d * (p * a_by_d + f * b_by_d) * scale,
             (f * slope - u * (p * a_by_gamma + f * b_by_gamma)) * scale,
             geometry_.lens_distance * u * p * secant_ * scale,
             -u * (p * a_by_angle + f * b_by_angle) * scale}};
  }

 private:
  LepGeometry<double> geometry_;
  double tangent_;
  double secant_;
};

/// The components of the scan by the parameters: the origin passes, the projected vergence turns
/// the rays from z towards x, and the errors of lengths are relative.
std::array<double, scan_size * parameter_count> scan_by_parameters(
    const LepRanging::Parameters<double>& p) {
  std::array<double, scan_size * parameter_count> jacobian{};
  const auto set = [&](std::size_t component, std::size_t parameter, double value) {
    jacobian[parameter * scan_size + component] = value;
  };
  set(0, 4, 1);
  set(1, 5, 1);
  set(2, 6, -1);
  set(7, 6, 1);
  set(3, 0, 1 / p.focal_length);
  set(4, 1, 1 / p.baseline);
  set(5, 2, 1);
  set(6, 3, p.lens_distance == 0 ? 0 : 1 / p.lens_distance);
  return jacobian;
}

}  // namespace

Interface LepRanging::interface() {
  return {.inputs = {{"scan", &descriptor<LepScan>()}},
          .output = &descriptor<RangeScan>(),
          .frame_of_input = 0};
}

Outcome<> LepRanging::evaluate(const Evaluation& evaluation, Output& output) {
  const auto p = payload_of<Parameters>(evaluation.parameters);
  if (!(p.focal_length > 0 && p.baseline > 0 && std::cos(p.vergence) > 1e-6))
    return Fault{FaultKind::out_of_range,
                 "focal_length and baseline must be above 0, vergence within ±90 deg"};
  const std::span<const LepReading> images = lep_readings_of(*evaluation.inputs[0]);
  const std::span<RangeReading> readings = make_readings(output, images.size());
  const RangeEquation range_equation({p.focal_length, p.baseline, p.vergence, p.lens_distance});
  std::size_t count = 0;
  for (const LepReading& image : images) {
    const double laser = image.scan_angle + p.projected_vergence;
    const InverseRange range =
        range_equation(image.image_position, std::cos(laser), std::sin(laser));
    if (!(range.value > 0 && range.by_position > 0)) continue;
    const double turned = image.vehicle_heading + image.head;
    const double c = std::cos(turned);
    const double s = std::sin(turned);
    readings[count++] = {image.time,
                         turned,
                         image.vehicle_x + c * p.origin_x - s * p.origin_z,
                         image.vehicle_z + s * p.origin_x + c * p.origin_z,
                         std::numbers::pi / 2 - laser + turned,
                         range.value,
                         range.by_position * image.deviation,
                         range.sensitivity};
  }
  make_readings(output, count);
  if (count == 0)
    return Fault{FaultKind::out_of_range,
                 "no image position belongs to a range in front of the "
                 "sensor; is the calibration this sensor's?"};
  const auto scan = payload_of<LepScan>(evaluation.input(0));
  assign<RangeScan>(output.estimate, {p.origin_x, p.origin_z, -p.projected_vergence, 0, 0, 0, 0, 0,
                                      scan.noise_correlation, scan.beam_width, 0});
  const auto jacobian = scan_by_parameters(p);
  const LineageTerm term{jacobian.data(), &evaluation.parameters.lineage};
  compose({&term, 1}, scan_size, output.estimate.lineage);
  return {};
}

}  // namespace ilss
