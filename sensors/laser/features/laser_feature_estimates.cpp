#include "sensors/laser/features/laser_feature_estimates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "framework/estimate/angle.h"

namespace ilss {
namespace {

/// The sources that belong to a segment: its fit's noise, where its ends lie, what it
/// departs from first order, and where within a step an edge lies at either end.
constexpr std::uint32_t columns_of_segment = 8;
constexpr std::uint32_t column_of_start = 3;
constexpr std::uint32_t column_of_end = 4;
constexpr std::uint32_t column_of_second_order = 5;
constexpr std::uint32_t column_of_first_edge = 6;
constexpr std::uint32_t column_of_last_edge = 7;

constexpr Eigen::Index laser_dimension = dimension_of<SegmentedScan>;
constexpr auto bias_column = static_cast<Eigen::Index>(first_bias);
constexpr auto bias_count = static_cast<Eigen::Index>(range_biases);
constexpr auto mount_column = static_cast<Eigen::Index>(first_mount);

using Vector2 = Eigen::Vector2d;

/// Factor L with L Lᵀ = covariance.
template <int P>
Eigen::Matrix<double, P, P> factor_of(const Eigen::Matrix<double, P, P>& covariance) {
  if constexpr (P == 2) {
    const double first = std::sqrt(covariance(0, 0));
    const double mixed = covariance(1, 0) / first;
    Eigen::Matrix2d factor;
    factor << first, 0, mixed, std::sqrt(std::max(0.0, covariance(1, 1) - mixed * mixed));
    return factor;
  } else {
    return covariance.llt().matrixL();
  }
}

template <int Rows>
std::span<const double> column_of(const Eigen::Matrix<double, Rows, 1>& column) {
  return {column.data(), static_cast<std::size_t>(Rows)};
}

/// What each bias adds to a range that is such a share of the biases' reference.
Eigen::Matrix<double, 1, bias_count> powers_of(double share) {
  Eigen::Matrix<double, 1, bias_count> powers;
  double power = 1;
  for (Eigen::Index k = 0; k < bias_count; ++k, power *= share) powers[k] = power;
  return powers;
}

/// A place on a line where a beam meets it, in the laser's frame, with its derivatives by the
/// line's (rho, alpha) and by the beam's bearing.
struct PlaceOnLine {
  Vector2 at;
  Eigen::Matrix2d by_line;
  Vector2 by_bearing;
};

PlaceOnLine meet(const LaserLineFit& line, double beam_cosine, double beam_sine) {
  const double c = line.cosine * beam_cosine + line.sine * beam_sine;
  const double s = line.sine * beam_cosine - line.cosine * beam_sine;
  const Vector2 beam(beam_cosine, beam_sine);
  const double range = line.rho / c;
  PlaceOnLine place;
  place.at = range * beam;
  place.by_line << beam / c, beam * (range * s / c);
  place.by_bearing = Vector2(-line.sine, line.cosine) * (range / c);
  return place;
}

}  // namespace

LaserFeatureWriter::LaserFeatureWriter(const Evaluation& evaluation, const LaserNoise& noise,
                                       Output& output)
    : evaluation_(evaluation),
      noise_(noise),
      mount_(mount_of(evaluation.input(0))),
      cosine_(std::cos(mount_.heading)),
      sine_(std::sin(mount_.heading)),
      has_systematic_errors_(!evaluation.input(0).lineage.empty()),
      output_(output) {}

Source LaserFeatureWriter::source(std::size_t segment, std::uint32_t column) const {
  return evaluation_.fresh(columns_of_segment * static_cast<std::uint32_t>(segment) + column);
}

Estimate& LaserFeatureWriter::next(const PayloadDescriptor& type) {
  if (count_ == output_.elements.size()) output_.elements.emplace_back();
  Estimate& element = output_.elements[count_++];
  element.type = &type;
  element.frame = output_.estimate.frame;
  element.labels.assign(type.labels.size(), 0);
  element.lineage.reset(type.components.size());
  return element;
}

/// A direction of the laser's frame (x forward, y to the left) in the robot's plane.
Vector2 LaserFeatureWriter::turn(const Vector2& place) const {
  return {place.x() * cosine_ + place.y() * sine_, place.x() * sine_ - place.y() * cosine_};
}

/// Rows `row` and `row + 1` are a place of the laser's frame.
template <int Rows, int P>
void LaserFeatureWriter::set_place(Feature<Rows, P>& feature, int row, const Vector2& place,
                                   const Eigen::Matrix<double, 2, P>& by_fit) const {
  const Vector2 turned = turn(place);
  feature.value[row] = mount_.x + turned.x();
  feature.value[row + 1] = mount_.z + turned.y();
  for (int k = 0; k < P; ++k) feature.by_fit.template block<2, 1>(row, k) = turn(by_fit.col(k));
  feature.by_mount.template block<2, 3>(row, 0) << 1, 0, -turned.y(), 0, 1, turned.x();
}

/// Rows for the distance and the normal's direction of a line in the robot's plane.
template <int Rows>
void LaserFeatureWriter::set_line(Feature<Rows, 2>& feature, int rho_row, int phi_row,
                                  const LaserLineFit& line) const {
  // phi = heading - alpha, rho = rho' + mount · normal; both may have to turn round.
  double phi = mount_.heading - line.alpha;
  const double cosine = cosine_ * line.cosine + sine_ * line.sine;
  const double sine = sine_ * line.cosine - cosine_ * line.sine;
  double rho = line.rho + mount_.x * cosine + mount_.z * sine;
  const double by_phi = mount_.z * cosine - mount_.x * sine;
  const double sign = rho < 0 ? -1 : 1;
  if (rho < 0) {
    rho = -rho;
    phi += std::numbers::pi;
  }
  feature.value[phi_row] = wrap_angle(phi);
  feature.by_fit.row(phi_row) << 0, -1;
  feature.by_mount.row(phi_row) << 0, 0, 1;
  if (rho_row < 0) return;
  feature.value[rho_row] = rho;
  feature.by_fit.row(rho_row) << sign, -sign * by_phi;
  feature.by_mount.row(rho_row) << sign * cosine, sign * sine, sign * by_phi;
}

/// Appends a feature, its lineage so far only what comes from the mount and the ranges' systematic
/// errors.
template <int Rows, int P>
Estimate& LaserFeatureWriter::write(const PayloadDescriptor& type,
                                    const Feature<Rows, P>& feature) {
  Estimate& element = next(type);
  element.value.assign(feature.value.data(), feature.value.data() + Rows);
  if (!has_systematic_errors_) return element;
  Eigen::Matrix<double, Rows, laser_dimension> by_scan =
      Eigen::Matrix<double, Rows, laser_dimension>::Zero();
  by_scan.template middleCols<bias_count>(bias_column) = feature.by_bias;
  by_scan.template middleCols<3>(mount_column) = feature.by_mount;
  const LineageTerm term{by_scan.data(), &evaluation_.input(0).lineage};
  compose({&term, 1}, static_cast<std::size_t>(Rows), element.lineage);
  return element;
}

void LaserFeatureWriter::add(std::size_t index, const LaserSegment& segment,
                             std::span<const ScanPoint> scan) {
  ++segments_;
  if (segment.arc)
    add_arc(index, segment, scan);
  else
    add_line(index, segment, scan);
}

void LaserFeatureWriter::add_line(std::size_t index, const LaserSegment& segment,
                                  std::span<const ScanPoint> scan) {
  constexpr int rows = dimension_of<LineSegment>;
  const LaserLineFit& line = segment.line;
  Feature<rows, 2> feature;
  set_line(feature, 0, 1, line);
  const ScanPoint& first = scan[segment.run.begin];
  const ScanPoint& last = scan[segment.run.end - 1];
  const PlaceOnLine start = meet(line, first.cosine, first.sine);
  const PlaceOnLine end = meet(line, last.cosine, last.sine);
  set_place(feature, 2, start.at, start.by_line);
  set_place(feature, 4, end.at, end.by_line);
  feature.value[6] = static_cast<double>(line.readings);
  feature.value[7] = static_cast<double>(segment.run.begin);
  feature.value[8] = static_cast<double>(segment.run.end - 1);
  if (has_systematic_errors_) feature.by_bias = feature.by_fit * line.by_bias;
  Estimate& element = write(descriptor<LineSegment>(), feature);
  const bool is_open = segment.run.begin == 0 || segment.run.end == scan.size();
  element.labels[0] = is_open ? 1 : 0;
  const Eigen::Matrix2d factor = factor_of(line.covariance);
  const Eigen::Matrix<double, rows, 2> columns = feature.by_fit * factor;
  element.lineage.add(source(index, 0), column_of<rows>(columns.col(0)));
  element.lineage.add(source(index, 1), column_of<rows>(columns.col(1)));
  // An end lies on the line, also on one that is turned: second order, along the normal. Four
  // times its root mean square, for a product of errors has longer tails than an error.
  const Vector2 normal = turn(Vector2(line.cosine, line.sine));
  const auto add_end = [&](int row, std::uint32_t column) {
    const Vector2 along(-normal.y(), normal.x());
    const Eigen::RowVector2d by_line =
        along.transpose() * feature.by_fit.template middleRows<2>(row);
    const double slide = (by_line * line.covariance * by_line.transpose()).value();
    Eigen::Matrix<double, rows, 1> values = Eigen::Matrix<double, rows, 1>::Zero();
    values.template segment<2>(row) = normal * 4 * std::sqrt(3 * line.covariance(1, 1) * slide);
    element.lineage.add(source(index, column), column_of<rows>(values));
  };
  add_end(2, column_of_start);
  add_end(4, column_of_end);
  element.lineage.add(source(index, column_of_second_order), 0,
                      std::sqrt(line.second_order_variance()));
}

void LaserFeatureWriter::add_arc(std::size_t index, const LaserSegment& segment,
                                 std::span<const ScanPoint> scan) {
  constexpr int rows = dimension_of<ArcSegment>;
  const LaserArcFit& arc = *segment.arc;
  Feature<rows, 3> feature;
  const Vector2 centre(arc.x, arc.y);
  Eigen::Matrix<double, 2, 3> by_circle;
  by_circle << 1, 0, 0, 0, 1, 0;
  set_place<rows, 3>(feature, 0, centre, by_circle);
  feature.value[2] = arc.radius;
  feature.by_fit.row(2) << 0, 0, 1;
  feature.by_mount.row(2).setZero();
  // An end is where the first or last beam meets the circle, or, of a beam that grazes it, the
  // point of the circle next to its reading.
  Eigen::Matrix<double, rows, bias_count> by_slide =
      Eigen::Matrix<double, rows, bias_count>::Zero();
  std::array<Vector2, 2> by_noise{Vector2::Zero(), Vector2::Zero()};
  const std::array<const ScanPoint*, 2> ends{&scan[segment.run.begin], &scan[segment.run.end - 1]};
  const double sign = arc.radius < 0 ? -1 : 1;
  for (int i = 0; i < 2; ++i) {
    const ScanPoint& p = *ends[static_cast<std::size_t>(i)];
    const Vector2 beam(p.cosine, p.sine);
    const Vector2 met = range_of(arc, p) * beam;
    Vector2 normal = (met - centre).normalized();
    const double incidence = normal.dot(beam);
    constexpr double grazing = 0.2;
    if (std::abs(incidence) > grazing) {
      by_circle << beam * normal.transpose() / incidence, beam * (sign / incidence);
      set_place<rows, 3>(feature, 3 + 2 * i, met, by_circle);
      continue;
    }
    normal = (Vector2(p.x, p.y) - centre).normalized();
    const Vector2 tangent(-normal.y(), normal.x());
    by_circle << normal * normal.transpose(), sign * normal;
    set_place<rows, 3>(feature, 3 + 2 * i, centre + std::abs(arc.radius) * normal, by_circle);
    const double along = tangent.dot(beam);
    by_slide.middleRows<2>(3 + 2 * i) =
        turn(tangent) * along * powers_of(p.range / evaluation_.input(0).value[bias_range]);
    by_noise[static_cast<std::size_t>(i)] =
        turn(tangent) *
        std::sqrt(noise_.range_variance * along * along +
                  p.range * p.range * noise_.bearing_variance * (1 - along * along));
  }
  if (has_systematic_errors_) feature.by_bias = feature.by_fit * arc.by_bias + by_slide;
  feature.value[7] = static_cast<double>(arc.readings);
  feature.value[8] = static_cast<double>(segment.run.begin);
  feature.value[9] = static_cast<double>(segment.run.end - 1);
  Estimate& element = write(descriptor<ArcSegment>(), feature);
  const Eigen::Matrix3d factor = factor_of(arc.covariance);
  const Eigen::Matrix<double, rows, 3> columns = feature.by_fit * factor;
  for (int k = 0; k < 3; ++k)
    element.lineage.add(source(index, static_cast<std::uint32_t>(k)),
                        column_of<rows>(columns.col(k)));
  const Eigen::Matrix<double, rows, 1> second_order = feature.by_fit * arc.second_order();
  element.lineage.add(source(index, column_of_second_order), column_of<rows>(second_order));
  for (int i = 0; i < 2; ++i) {
    Eigen::Matrix<double, rows, 1> column = Eigen::Matrix<double, rows, 1>::Zero();
    column.template segment<2>(3 + 2 * i) = by_noise[static_cast<std::size_t>(i)];
    element.lineage.add(source(index, i == 0 ? column_of_start : column_of_end),
                        column_of<rows>(column));
  }
}

void LaserFeatureWriter::add_corner(std::size_t a, const LaserLineFit& line_a, std::size_t b,
                                    const LaserLineFit& line_b, CornerKind kind) {
  // n_a · p = rho_a and n_b · p = rho_b; a turned line moves by its coordinate along itself.
  Eigen::Matrix2d normals;
  normals << line_a.cosine, line_a.sine, line_b.cosine, line_b.sine;
  const Eigen::Matrix2d inverse = normals.inverse();
  const Vector2 place = inverse * Vector2(line_a.rho, line_b.rho);
  const auto by_line = [&](int row) {
    const Vector2 normal = normals.row(row);
    Eigen::Matrix2d by;
    by << inverse.col(row), inverse.col(row) * (normal.y() * place.x() - normal.x() * place.y());
    return by;
  };
  Feature<2, 4> feature;
  Eigen::Matrix<double, 2, 4> by_lines;
  by_lines << by_line(0), by_line(1);
  set_place<2, 4>(feature, 0, place, by_lines);
  Eigen::Matrix<double, 4, bias_count> by_bias;
  by_bias << line_a.by_bias, line_b.by_bias;
  if (has_systematic_errors_) feature.by_bias = feature.by_fit * by_bias;
  Estimate& element = write(descriptor<Corner>(), feature);
  element.labels[0] = static_cast<int>(kind);
  const auto add_noise = [&](std::size_t segment, const Eigen::Matrix2d& by_fit,
                             const Eigen::Matrix2d& covariance) {
    const Eigen::Matrix2d columns = by_fit * factor_of(covariance);
    element.lineage.add(source(segment, 0), column_of<2>(columns.col(0)));
    element.lineage.add(source(segment, 1), column_of<2>(columns.col(1)));
  };
  add_noise(a, feature.by_fit.leftCols<2>(), line_a.covariance);
  add_noise(b, feature.by_fit.rightCols<2>(), line_b.covariance);
}

void LaserFeatureWriter::add_edge(std::size_t index, const LaserLineFit& line,
                                  const ScanPoint& beam, const ScanPoint& neighbour) {
  const double step = neighbour.bearing - beam.bearing;
  const double middle = beam.bearing + step / 2;
  const PlaceOnLine place = meet(line, std::cos(middle), std::sin(middle));
  Feature<3, 2> feature;
  set_place(feature, 0, place.at, place.by_line);
  set_line(feature, -1, 2, line);
  if (has_systematic_errors_) feature.by_bias = feature.by_fit * line.by_bias;
  Estimate& element = write(descriptor<SurfaceEdge>(), feature);
  const Eigen::Matrix<double, 3, 2> columns = feature.by_fit * factor_of(line.covariance);
  element.lineage.add(source(index, 0), column_of<3>(columns.col(0)));
  element.lineage.add(source(index, 1), column_of<3>(columns.col(1)));
  // Anywhere between the two beams as they really look: their middle is off by half the variance of
  // one, and of such pairs the wider ones hold an edge more often, by the other half.
  const double bearing_std = std::sqrt(step * step / 12 + noise_.bearing_variance);
  Eigen::Vector3d column = Eigen::Vector3d::Zero();
  column.head<2>() = turn(place.by_bearing) * bearing_std;
  element.lineage.add(source(index, step > 0 ? column_of_last_edge : column_of_first_edge),
                      column_of<3>(column));
}

void LaserFeatureWriter::finish() {
  output_.elements.resize(count_);
  assign<RangeFeatures>(output_.estimate, {static_cast<double>(segments_)});
}

}  // namespace ilss
