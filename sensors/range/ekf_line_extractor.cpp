#include "sensors/range/ekf_line_extractor.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "sensors/range/line_extractor.h"

namespace ilss {
namespace {

struct Place {
  double x;
  double z;
};

/// A reading's point in the projection frame.
Place place_of(const PolarReading& reading) {
  return {reading.range * std::cos(reading.bearing), reading.range * std::sin(reading.bearing)};
}

Place turned(const Place& p, double angle) {
  return {std::cos(angle) * p.x - std::sin(angle) * p.z,
          std::sin(angle) * p.x + std::cos(angle) * p.z};
}

/// A point of the projection frame seen after the head has turned by `turn` about its axis.
Place after_rotation(const Place& p, const HeadAxis& axis, double turn) {
  const Place a{axis.distance * std::cos(axis.direction), axis.distance * std::sin(axis.direction)};
  const Place q = turned({p.x - a.x, p.z - a.z}, -turn);
  return {a.x + q.x, a.z + q.z};
}

/// (rho, phi) with rho not negative.
PolarLine normalised(PolarLine line) {
  if (line.state[0] < 0) {
    line.state[0] = -line.state[0];
    line.state[1] += std::numbers::pi;
    line.covariance(0, 1) = -line.covariance(0, 1);
    line.covariance(1, 0) = -line.covariance(1, 0);
  }
  line.state[1] = wrap_angle(line.state[1]);
  return line;
}

/// A projection frame's line in the scan's frame, as m = (cos phi, sin phi) / rho.
LineFit in_scan_frame(const PolarLine& line, const RangeReading& at, double mount_heading) {
  const double phi = line.state[1] + at.head + mount_heading;
  const double c = std::cos(phi);
  const double s = std::sin(phi);
  const double rho = line.state[0] + c * at.origin_x + s * at.origin_z;
  Eigen::Matrix2d jacobian;  // of m by the projection frame's rho and phi
  const double rho_by_phi = -s * at.origin_x + c * at.origin_z;
  jacobian << -c / (rho * rho), -s / rho - c / (rho * rho) * rho_by_phi, -s / (rho * rho),
      c / rho - s / (rho * rho) * rho_by_phi;
  LineFit fit;
  fit.line = {c / rho, s / rho};
  fit.covariance = jacobian * line.covariance * jacobian.transpose();
  fit.by_scan.setZero();
  return fit;
}

PolarLine polar(const LineFit& fit) {
  const double norm = std::hypot(fit.line.x, fit.line.z);
  const double c = fit.line.x / norm;
  const double s = fit.line.z / norm;
  Eigen::Matrix2d jacobian;  // of rho and phi by m
  jacobian << -c / (norm * norm), -s / (norm * norm), -s / norm, c / norm;
  return {{1 / norm, std::atan2(s, c)}, jacobian * fit.covariance * jacobian.transpose()};
}

}  // namespace

PolarLine predict_over_rotation(const PolarLine& line, const HeadAxis& axis, double turn,
                                double encoder_std) {
  const double before = line.state[1] - axis.direction;  // beta(k), eq. 16
  const double after = before - turn;                    // eq. 18
  PolarLine result;
  result.state = {line.state[0] + axis.distance * (std::cos(after) - std::cos(before)),
                  line.state[1] - turn};  // eq. 20
  Eigen::Matrix2d transition;             // eq. 22
  transition << 1, axis.distance * (std::sin(before) - std::sin(after)), 0, 1;
  Eigen::Vector2d noise(-axis.distance * std::sin(after), 1);  // eq. 23 to 25
  noise *= encoder_std;
  result.covariance =
      transition * line.covariance * transition.transpose() + noise * noise.transpose();
  return result;
}

PolarInnovation polar_innovation(const PolarLine& line, double bearing, double range,
                                 double range_variance) {
  const double c = std::cos(line.state[1] - bearing);
  const double expected = line.state[0] / c;
  PolarInnovation result;
  result.value = range - expected;
  result.jacobian << 1 / c, expected * std::tan(line.state[1] - bearing);
  result.variance =
      result.jacobian * line.covariance * result.jacobian.transpose() + range_variance;
  return result;
}

PolarLine update(const PolarLine& line, const PolarInnovation& innovation) {
  const Eigen::Vector2d gain =
      line.covariance * innovation.jacobian.transpose() / innovation.variance;
  return {line.state + gain * innovation.value,
          line.covariance - gain * innovation.variance * gain.transpose()};
}

std::optional<PolarLine> batch_line(std::span<const PolarReading> readings, const HeadAxis& axis) {
  // (i) into the frame of the last reading, (ii) the centroid and its angle from the z axis.
  std::vector<Place> places;
  Place centroid{0, 0};
  for (const PolarReading& reading : readings) {
    const Place p = after_rotation(place_of(reading), axis, readings.back().head - reading.head);
    centroid.x += p.x / static_cast<double>(readings.size());
    centroid.z += p.z / static_cast<double>(readings.size());
    places.push_back(p);
  }
  const double from_z = std::atan2(centroid.x, centroid.z);
  // (iii) the centroid on the z axis, (iv) weighted least squares z = a x + b.
  double w = 0;
  double wx = 0;
  double wz = 0;
  double wxx = 0;
  double wxz = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place p = turned(places[i], from_z);
    const double share = p.z / std::hypot(p.x, p.z);
    const double weight = 1 / (readings[i].variance * share * share);  // of z
    w += weight;
    wx += weight * p.x;
    wz += weight * p.z;
    wxx += weight * p.x * p.x;
    wxz += weight * p.x * p.z;
  }
  const double determinant = w * wxx - wx * wx;
  if (!(determinant > 0)) return std::nullopt;
  const double slope = (w * wxz - wx * wz) / determinant;
  const double intercept = (wxx * wz - wx * wxz) / determinant;
  // (v) polar, eq. 38.
  PolarLine line;
  line.state = {intercept * std::cos(std::atan(slope)),
                std::atan(slope) - from_z + std::numbers::pi / 2};
  // (vi) covariance, eq. 39 and 40.
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  line.covariance.setZero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const PolarInnovation row = polar_innovation(line, std::atan2(places[i].z, places[i].x), 0, 1);
    information += row.jacobian.transpose() * row.jacobian / readings[i].variance;
  }
  if (!(information.determinant() > 0)) return std::nullopt;
  line.covariance = information.inverse();
  if (!line.state.allFinite() || !line.covariance.allFinite()) return std::nullopt;
  return line;
}

void EkfLineExtractor::Options::declare(OptionVisitor& visit) {
  visit("gate", gate, "g, of the validation gate, in standard deviations", {.minimum = 0});
  visit("batch_readings", batch_readings, "k, with which a line starts",
        {.minimum = 2, .maximum = 1000});
  visit("encoder_std", encoder_std, "error of each measured rotation of the head",
        {.unit = "rad", .minimum = 0});
  visit("cluster_gate", cluster_gate,
        "joins segments whose lines are within so many standard deviations in (rho, phi)",
        {.minimum = 0});
}

Interface EkfLineExtractor::interface() { return LineExtractor::interface({}); }

void EkfLineExtractor::extract(std::span<const RangeReading> readings,
                               const RangeScan<double>& scan) {
  // The axis seen from where the rays start, eq. 17.
  const Place origin = turned({scan.mount_x, scan.mount_z}, -scan.mount_heading);
  const HeadAxis axis{std::hypot(origin.x, origin.z), std::atan2(-origin.z, -origin.x)};
  polar_.clear();
  for (const RangeReading& r : readings) {
    const double range = 1 / r.inverse_range;
    const double deviation = r.deviation * range * range;  // eq. 31 and 32
    polar_.push_back(
        {r.bearing - r.head - scan.mount_heading, range, deviation * deviation, r.head});
  }
  const auto batch = static_cast<std::size_t>(options_.batch_readings);
  segments_.clear();
  for (std::size_t begin = 0; begin + batch <= polar_.size();) {
    std::size_t end = begin + batch;
    auto line = batch_line(std::span(polar_).subspan(begin, batch), axis);
    if (!line) {
      ++begin;
      continue;
    }
    for (; end < polar_.size(); ++end) {
      const PolarReading& r = polar_[end];
      const PolarLine predicted =
          predict_over_rotation(*line, axis, r.head - polar_[end - 1].head, options_.encoder_std);
      const PolarInnovation innovation =
          polar_innovation(predicted, r.bearing, r.range, r.variance);
      if (innovation.value * innovation.value > options_.gate * options_.gate * innovation.variance)
        break;  // eq. 33
      line = update(predicted, innovation);
    }
    FittedSegment segment;
    segment.fit = in_scan_frame(normalised(*line), readings[end - 1], scan.mount_heading);
    segment.fit.readings = end - begin;
    segment.runs = {{begin, end}};
    segment.first = begin;
    segment.last = end - 1;
    if (std::isfinite(segment.fit.line.x + segment.fit.line.z) &&
        segment.fit.covariance.allFinite() && segment.fit.covariance.determinant() > 0)
      segments_.push_back(segment);
    begin = end;
  }
}

/// Clustering with weighted averaging in (rho, phi), the paper's proposal (sec. 4.7).
void EkfLineExtractor::cluster() {
  std::vector<FittedSegment> clusters;
  for (const FittedSegment& segment : segments_) {
    const PolarLine line = polar(segment.fit);
    bool joined = false;
    for (FittedSegment& known : clusters) {
      const PolarLine other = polar(known.fit);
      Eigen::Vector2d difference = line.state - other.state;
      difference[1] = wrap_angle(difference[1]);
      const Eigen::Matrix2d sum = line.covariance + other.covariance;
      if (difference.dot(sum.inverse() * difference) >
          *options_.cluster_gate * *options_.cluster_gate)
        continue;
      const Eigen::Matrix2d gain = other.covariance * sum.inverse();
      const PolarLine mean =
          normalised({other.state + gain * difference, other.covariance - gain * other.covariance});
      const std::size_t readings = known.fit.readings + segment.fit.readings;
      known.fit = in_scan_frame(mean, RangeReading{}, 0);
      known.fit.readings = readings;
      known.last = segment.last;
      known.runs.push_back(segment.runs.front());
      joined = true;
      break;
    }
    if (!joined) clusters.push_back(segment);
  }
  segments_.swap(clusters);
}

Outcome<> EkfLineExtractor::evaluate(const Evaluation& evaluation, Output& output) {
  const std::span<const RangeReading> readings = readings_of(*evaluation.inputs[0]);
  if (readings.size() < static_cast<std::size_t>(options_.batch_readings))
    return Fault{FaultKind::no_detection,
                 fmt::format("the scan has {} readings; a segment needs {}", readings.size(),
                             options_.batch_readings)};
  if (Outcome<> outcome = check_readings(readings); !outcome) return outcome;
  extract(readings, payload_of<RangeScan>(evaluation.input(0)));
  if (options_.cluster_gate) cluster();
  FeatureWriter writer(evaluation, evaluation.input(0), output);
  for (const FittedSegment& segment : segments_) writer.add(segment, readings);
  writer.finish();
  return {};
}

}  // namespace ilss
