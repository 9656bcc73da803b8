#include "sensors/range/feature_estimates.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "framework/estimate/differentiate.h"

namespace ilss {
namespace {

constexpr Eigen::Index scan_size = dimension_of<RangeScan>;
constexpr Eigen::Index mount_size = 3;

/// The sources that belong to a segment: its fit's noise, what a line's rho departs from first
/// order, and where within a ray's step its two ends lie.
constexpr std::uint32_t columns_of_segment = 8;
constexpr std::uint32_t column_of_second_order = 4;
constexpr std::uint32_t column_of_start = 5;
constexpr std::uint32_t column_of_end = 6;

template <typename T>
struct Point {
  T x, z;
};

/// A reading's ray, its origin and bearing moving with the scan's mount.
template <typename T>
struct Ray {
  T origin_x, origin_z, direction_x, direction_z;

  Ray(const RangeReading& reading, const T& mount_x, const T& mount_z, const T& heading) {
    using std::cos;
    using std::sin;
    const double c = std::cos(reading.head);
    const double s = std::sin(reading.head);
    origin_x = reading.origin_x + c * mount_x - s * mount_z;
    origin_z = reading.origin_z + s * mount_x + c * mount_z;
    direction_x = cos(reading.bearing + heading);
    direction_z = sin(reading.bearing + heading);
  }
  Point<T> at(const T& range) const {
    return {origin_x + range * direction_x, origin_z + range * direction_z};
  }
};

/// Where a ray meets the line m · x = 1.
template <typename T>
Point<T> meet_line(const Ray<T>& ray, const T& mx, const T& mz) {
  return ray.at((T(1) - mx * ray.origin_x - mz * ray.origin_z) /
                (mx * ray.direction_x + mz * ray.direction_z));
}

template <typename T>
Point<T> meet_circle(const Ray<T>& ray, const T& cx, const T& cz, const T& radius) {
  return ray.at(range_to_circle(ray.origin_x, ray.origin_z, ray.direction_x, ray.direction_z, cx,
                                cz, radius));
}

/// What a feature is computed from, as variables of differentiation: its fit's parameters first,
/// then the change of the scan's mount (0).
template <int N>
using Variables = std::array<Dual<static_cast<std::size_t>(N)>, static_cast<std::size_t>(N)>;

template <int N>
Variables<N> variables(const Eigen::Matrix<double, N, 1>& values) {
  Variables<N> result;
  for (int i = 0; i < N; ++i)
    result[static_cast<std::size_t>(i)] = Dual<static_cast<std::size_t>(N)>(values[i], i);
  return result;
}

/// Writes values and lineage of a feature that follows from a fit of P parameters and the mount:
/// `components` are duals over P + 3 variables.
template <int P, std::size_t Rows, typename T>
void write_feature(const std::array<T, Rows>& components, const Eigen::Matrix<double, P, P>& noise,
                   const Eigen::Matrix<double, P, scan_dependences>& by_scan, const Estimate& scan,
                   const std::array<Source, P>& sources, Estimate& out) {
  constexpr auto rows = static_cast<Eigen::Index>(Rows);
  Eigen::Matrix<double, rows, P> by_fit;
  Eigen::Matrix<double, rows, mount_size> by_mount;
  out.value.resize(Rows);
  for (std::size_t i = 0; i < Rows; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    out.value[i] = components[i].a;
    by_fit.row(row) = components[i].v.template head<P>().transpose();
    by_mount.row(row) = components[i].v.template tail<mount_size>().transpose();
  }
  Eigen::Matrix<double, rows, scan_size> jacobian = Eigen::Matrix<double, rows, scan_size>::Zero();
  jacobian.template leftCols<scan_dependences>() = by_fit * by_scan;
  jacobian.template leftCols<mount_size>() += by_mount;
  const LineageTerm term{jacobian.data(), &scan.lineage};
  compose({&term, 1}, Rows, out.lineage);
  const Eigen::Matrix<double, P, P> factor = noise.llt().matrixL();
  const Eigen::Matrix<double, rows, P> columns = by_fit * factor;
  for (int k = 0; k < P; ++k)
    out.lineage.add(sources[static_cast<std::size_t>(k)],
                    std::span<const double>(columns.col(k).data(), Rows));
}

double inverse_range_at(const RangeReading& r, const InverseLine& m) {
  return (m.x * std::cos(r.bearing) + m.z * std::sin(r.bearing)) /
         (1 - m.x * r.origin_x - m.z * r.origin_z);
}

/// Where the nearer surface ends at a jump: the bearing from a reading's ray to the middle of the
/// interval that holds the end, and the interval's width (rad).
struct JumpInterval {
  const RangeReading* reading;
  double middle;
  double width;
};

/// Readings at a jump, from the nearer surface outwards: the last one that its line was fitted to,
/// the last that is of it, and the first that is of the farther surface.
struct JumpReadings {
  std::size_t clean, nearer, farther;
};

/// The last reading that is of the nearer surface has more light of that one, and the first that is
/// of the farther one has more of the other: between these two the nearer surface ends. Where
/// readings are missing, nothing mixes: the last one before them has light of the beam's inner
/// edge, and the next has none.
JumpInterval jump_interval(std::span<const RangeReading> readings, const JumpReadings& at,
                           double beam_width) {
  const bool forward = at.farther > at.clean;
  const auto outwards = [&](std::size_t i) { return forward ? i + 1 : i - 1; };
  const double step =
      readings[at.clean].bearing - readings[forward ? at.clean - 1 : at.clean + 1].bearing;
  const auto last_contiguous = [&](std::size_t from, std::size_t to) {
    constexpr double missing = 1.5;  // steps
    while (from != to && std::abs(readings[outwards(from)].bearing - readings[from].bearing) <=
                             missing * std::abs(step))
      from = outwards(from);
    return from;
  };
  const std::size_t nearer = last_contiguous(at.clean, at.nearer);
  const std::size_t last = nearer == at.nearer ? last_contiguous(nearer, at.farther) : nearer;
  const RangeReading& reading = readings[nearer];
  const double width = readings[last].bearing - reading.bearing;
  if (last == at.farther) return {&reading, width / 2, width};
  const double half_beam = std::copysign(beam_width * reading.inverse_range / 2, step);
  return {&reading, width + step / 2 - half_beam, step};
}

}  // namespace

FeatureWriter::FeatureWriter(const Evaluation& evaluation, const Estimate& scan, Output& output)
    : evaluation_(evaluation), scan_(scan), output_(output) {}

/// One of the sources that belong to a segment.
Source FeatureWriter::source(std::size_t segment, std::uint32_t column) const {
  return evaluation_.fresh(columns_of_segment * static_cast<std::uint32_t>(segment) + column);
}

Estimate& FeatureWriter::next(const PayloadDescriptor& type) {
  if (count_ == output_.elements.size()) output_.elements.emplace_back();
  Estimate& element = output_.elements[count_++];
  element.type = &type;
  element.frame = scan_.frame;
  element.labels.clear();
  return element;
}

void FeatureWriter::add(const FittedSegment& segment, std::span<const RangeReading> readings,
                        bool is_open) {
  const RangeReading& first = readings[segment.first];
  const RangeReading& last = readings[segment.last];
  const std::size_t index = segments_++;
  if (segment.arc) {
    const ArcFit& fit = *segment.arc;
    Eigen::Matrix<double, 6, 1> values = Eigen::Matrix<double, 6, 1>::Zero();
    values.head<3>() = fit.circle;
    const auto v = variables<6>(values);
    using T = Dual<6>;
    const Point<T> start = meet_circle(Ray<T>(first, v[3], v[4], v[5]), v[0], v[1], v[2]);
    const Point<T> end = meet_circle(Ray<T>(last, v[3], v[4], v[5]), v[0], v[1], v[2]);
    const std::array<T, 10> components{v[0],
                                       v[1],
                                       v[2],
                                       start.x,
                                       start.z,
                                       end.x,
                                       end.z,
                                       T(static_cast<double>(fit.readings)),
                                       T(static_cast<double>(segment.first)),
                                       T(static_cast<double>(segment.last))};
    write_feature<3>(components, fit.covariance, fit.by_scan, scan_,
                     {source(index, 0), source(index, 1), source(index, 2)},
                     next(descriptor<ArcSegment>()));
    return;
  }
  const LineFit& fit = segment.fit;
  Eigen::Matrix<double, 5, 1> values = Eigen::Matrix<double, 5, 1>::Zero();
  values.head<2>() << fit.line.x, fit.line.z;
  const auto v = variables<5>(values);
  using T = Dual<5>;
  const Point<T> start = meet_line(Ray<T>(first, v[2], v[3], v[4]), v[0], v[1]);
  const Point<T> end = meet_line(Ray<T>(last, v[2], v[3], v[4]), v[0], v[1]);
  const std::array<T, 9> components{1.0 / sqrt(v[0] * v[0] + v[1] * v[1]),
                                    atan2(v[1], v[0]),
                                    start.x,
                                    start.z,
                                    end.x,
                                    end.z,
                                    T(static_cast<double>(fit.readings)),
                                    T(static_cast<double>(segment.first)),
                                    T(static_cast<double>(segment.last))};
  Estimate& element = next(descriptor<LineSegment>());
  write_feature<2>(components, fit.covariance, fit.by_scan, scan_,
                   {source(index, 0), source(index, 1)}, element);
  // A short line turns about its middle, and its distance from the origin then changes by
  // -rho (change of phi)² / 2. First order does not see that; here is its root mean square.
  constexpr std::size_t rho = index_of<LineSegment>("rho");
  constexpr std::size_t phi = index_of<LineSegment>("phi");
  const double second_order = std::sqrt(0.75) * element.value[rho] * element.lineage.variance(phi);
  element.lineage.add(source(index, column_of_second_order), rho, second_order);
  element.labels.assign(1, is_open ? 1 : 0);
}

void FeatureWriter::add_edge(const FittedSegment& before, const FittedSegment& after,
                             std::span<const RangeReading> readings) {
  if (before.arc || after.arc) return;
  const std::size_t second = segments_ - 1;
  const std::size_t first = segments_ - 2;
  if (after.meets_before) {
    // m1 · x = 1 and m2 · x = 1.
    Eigen::Vector4d values(before.fit.line.x, before.fit.line.z, after.fit.line.x,
                           after.fit.line.z);
    const auto v = variables<4>(values);
    const Dual<4> determinant = v[0] * v[3] - v[1] * v[2];
    if (determinant.a == 0) return;
    const std::array<Dual<4>, 2> place{(v[3] - v[1]) / determinant, (v[0] - v[2]) / determinant};
    Estimate& corner = next(descriptor<Corner>());
    Eigen::Matrix<double, 2, 4> by_fits;
    by_fits << place[0].v.transpose(), place[1].v.transpose();
    corner.value.assign({place[0].a, place[1].a});
    corner.labels.assign(1, static_cast<int>(CornerKind::real_corner));
    Eigen::Matrix<double, 2, scan_size> jacobian = Eigen::Matrix<double, 2, scan_size>::Zero();
    jacobian.leftCols<scan_dependences>() =
        by_fits.leftCols<2>() * before.fit.by_scan + by_fits.rightCols<2>() * after.fit.by_scan;
    const LineageTerm term{jacobian.data(), &scan_.lineage};
    compose({&term, 1}, 2, corner.lineage);
    const auto add_noise = [&](const Eigen::Matrix2d& by_fit, const Eigen::Matrix2d& noise,
                               std::size_t segment) {
      const Eigen::Matrix2d factor = noise.llt().matrixL();
      const Eigen::Matrix2d columns = by_fit * factor;
      for (std::uint32_t k = 0; k < 2; ++k)
        corner.lineage.add(source(segment, k), std::span<const double>(columns.col(k).data(), 2));
    };
    add_noise(by_fits.leftCols<2>(), before.fit.covariance, first);
    add_noise(by_fits.rightCols<2>(), after.fit.covariance, second);
    return;
  }
  // Where many readings between the two belong to neither, something else stands there.
  constexpr std::size_t most_outliers = 4;
  if (after.first - before.last > before.mixed_after + after.mixed_before + most_outliers + 1)
    return;
  const RangeReading& opposite = readings[after.first];
  const bool before_is_nearer =
      inverse_range_at(opposite, before.fit.line) > inverse_range_at(opposite, after.fit.line);
  const FittedSegment& nearer = before_is_nearer ? before : after;
  // What is too weak to tell the one surface from the other belongs to neither.
  const auto distinguishes = [&](std::size_t i) {
    constexpr double least_separation = 3;  // standard deviations
    return std::abs(inverse_range_at(readings[i], before.fit.line) -
                    inverse_range_at(readings[i], after.fit.line)) >
           least_separation * readings[i].deviation;
  };
  std::size_t end = before.last + before.mixed_after;
  while (end > before.last && !distinguishes(end)) --end;
  std::size_t begin = after.first - after.mixed_before;
  while (begin < after.first && !distinguishes(begin)) ++begin;
  const JumpInterval jump = jump_interval(readings,
                                          before_is_nearer ? JumpReadings{before.last, end, begin}
                                                           : JumpReadings{after.first, begin, end},
                                          payload_of<RangeScan>(scan_).beam_width);
  Eigen::Matrix<double, 6, 1> values = Eigen::Matrix<double, 6, 1>::Zero();
  values.head<2>() << nearer.fit.line.x, nearer.fit.line.z;
  const auto v = variables<6>(values);  // the line, the bearing, the mount
  using T = Dual<6>;
  const Ray<T> ray(*jump.reading, v[3], v[4], v[5] + v[2] + jump.middle);
  const Point<T> place = meet_line(ray, v[0], v[1]);
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  noise.topLeftCorner<2, 2>() = nearer.fit.covariance;
  noise(2, 2) = jump.width * jump.width / 12;  // uniform
  Eigen::Matrix<double, 3, scan_dependences> by_scan =
      Eigen::Matrix<double, 3, scan_dependences>::Zero();
  by_scan.topRows<2>() = nearer.fit.by_scan;
  Estimate& edge = next(descriptor<SurfaceEdge>());
  const std::size_t index_of_nearer = before_is_nearer ? first : second;
  write_feature<3>(std::array<T, 3>{place.x, place.z, atan2(v[1], v[0])}, noise, by_scan, scan_,
                   {source(index_of_nearer, 0), source(index_of_nearer, 1),
                    source(index_of_nearer, before_is_nearer ? column_of_end : column_of_start)},
                   edge);
}

void FeatureWriter::finish() {
  output_.elements.resize(count_);
  assign<RangeFeatures>(output_.estimate, {static_cast<double>(segments_)});
}

}  // namespace ilss
