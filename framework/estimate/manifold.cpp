#include "framework/estimate/manifold.h"

#include <Eigen/LU>
#include <algorithm>

#include "framework/estimate/angle.h"
#include "framework/estimate/rotation.h"

namespace ilss {
namespace {

RotationVector<double> rotation_at(std::span<const double> values, std::size_t i) {
  return {values[i], values[i + 1], values[i + 2]};
}

void store(const RotationVector<double>& rotation, std::size_t i, std::span<double> out) {
  std::copy(rotation.begin(), rotation.end(), out.begin() + static_cast<std::ptrdiff_t>(i));
}

/// The identity with a block for each rotation.
template <typename Block>
Eigen::MatrixXd blocks(const PayloadDescriptor& type, std::span<const double> at, Block block) {
  const auto m = static_cast<Eigen::Index>(type.dimension());
  Eigen::MatrixXd result = Eigen::MatrixXd::Identity(m, m);
  for (std::size_t i = 0; i < type.dimension();) {
    if (type.components[i].geometry != Geometry::rotation) {
      ++i;
      continue;
    }
    const auto first = static_cast<Eigen::Index>(i);
    result.block<3, 3>(first, first) = block(rotation_at(at, i));
    i += 3;
  }
  return result;
}

RotationVector<double> inverse(const RotationVector<double>& rotation) {
  return {-rotation[0], -rotation[1], -rotation[2]};
}

}  // namespace

bool is_flat(const PayloadDescriptor& type) {
  return std::none_of(type.components.begin(), type.components.end(),
                      [](const Component& c) { return c.geometry == Geometry::rotation; });
}

void difference(const PayloadDescriptor& type, std::span<const double> a, std::span<const double> b,
                std::span<double> out) {
  for (std::size_t i = 0; i < type.dimension(); ++i) switch (type.components[i].geometry) {
      case Geometry::plain:
        out[i] = a[i] - b[i];
        break;
      case Geometry::circular:
        out[i] = wrap_angle(a[i] - b[i]);
        break;
      case Geometry::rotation:
        store(rotation_between(rotation_at(b, i), rotation_at(a, i)), i, out);
        i += 2;
        break;
    }
}

Eigen::VectorXd difference(const PayloadDescriptor& type, std::span<const double> a,
                           std::span<const double> b) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(type.dimension()));
  difference(type, a, b, std::span(result.data(), type.dimension()));
  return result;
}

void retract(const PayloadDescriptor& type, std::span<const double> value,
             std::span<const double> error, std::span<double> out) {
  for (std::size_t i = 0; i < type.dimension(); ++i) switch (type.components[i].geometry) {
      case Geometry::plain:
        out[i] = value[i] + error[i];
        break;
      case Geometry::circular:
        out[i] = wrap_angle(value[i] + error[i]);
        break;
      case Geometry::rotation:
        store(rotation_product(rotation_at(value, i), rotation_at(error, i)), i, out);
        i += 2;
        break;
    }
}

std::vector<double> retract(const PayloadDescriptor& type, std::span<const double> value,
                            std::span<const double> error) {
  std::vector<double> result(type.dimension());
  retract(type, value, error, result);
  return result;
}

void normalize(const PayloadDescriptor& type, std::span<double> value) {
  for (std::size_t i = 0; i < type.dimension(); ++i) switch (type.components[i].geometry) {
      case Geometry::plain:
        break;
      case Geometry::circular:
        value[i] = wrap_angle(value[i]);
        break;
      case Geometry::rotation:
        store(shortest(rotation_at(value, i)), i, value);
        i += 2;
        break;
    }
}

Eigen::MatrixXd difference_by_first(const PayloadDescriptor& type, std::span<const double> d) {
  return blocks(type, d, inverse_right_jacobian);
}

Eigen::MatrixXd difference_by_second(const PayloadDescriptor& type, std::span<const double> d) {
  return -blocks(type, d,
                 [](const auto& rotation) { return inverse_right_jacobian(inverse(rotation)); });
}

Eigen::MatrixXd retract_by_value(const PayloadDescriptor& type, std::span<const double> e) {
  return blocks(type, e, [](const auto& rotation) { return rotation_matrix(inverse(rotation)); });
}

Eigen::MatrixXd retract_by_error(const PayloadDescriptor& type, std::span<const double> e) {
  return blocks(type, e, right_jacobian);
}

void jacobian_of_errors(const PayloadDescriptor& out, std::span<const double> out_value,
                        const PayloadDescriptor& in, std::span<const double> in_value,
                        std::span<double> jacobian) {
  Eigen::Map<Eigen::MatrixXd> j(jacobian.data(), static_cast<Eigen::Index>(out.dimension()),
                                static_cast<Eigen::Index>(in.dimension()));
  if (!is_flat(in)) j = (j * difference_by_first(in, in_value)).eval();
  if (!is_flat(out)) j = (retract_by_error(out, out_value) * j).eval();
}

std::vector<double> weighted_mean(const PayloadDescriptor& type,
                                  std::span<const std::span<const double>> values,
                                  std::span<const double> weights) {
  constexpr int most_steps = 50;
  constexpr double rounding = 1e-14;
  const auto m = static_cast<Eigen::Index>(type.dimension());
  std::vector<double> mean(values.front().begin(), values.front().end());
  Eigen::VectorXd apart(m);
  const auto of = [&](Eigen::VectorXd& vector) {
    return std::span<double>(vector.data(), type.dimension());
  };
  for (int step = 0; step < most_steps; ++step) {
    Eigen::VectorXd move = Eigen::VectorXd::Zero(m);
    for (std::size_t n = 0; n < values.size(); ++n) {
      difference(type, values[n], mean, of(apart));
      move += weights[n] * apart;
    }
    retract(type, mean, of(move), mean);
    if (is_flat(type) || move.cwiseAbs().maxCoeff() <= rounding) break;
  }
  return mean;
}

void transport_gains(const PayloadDescriptor& type, const Eigen::MatrixXd& differences,
                     Eigen::MatrixXd& gains) {
  if (is_flat(type)) return;
  const Eigen::Index m = differences.rows();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index i = 0; i < differences.cols(); ++i) {
    const std::span<const double> d(differences.data() + i * m, static_cast<std::size_t>(m));
    auto gain = gains.middleCols(i * m, m);
    sum -= gain * difference_by_second(type, d);
    gain = (gain * difference_by_first(type, d)).eval();
  }
  gains = sum.partialPivLu().solve(gains).eval();
}

}  // namespace ilss
