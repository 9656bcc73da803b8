// Jacobians of formulas that are generic in the scalar, by forward automatic differentiation.
#pragma once

#include <ceres/jet.h>

#include <array>
#include <cstddef>
#include <span>

namespace ilss {

/// Value and Jacobian (Rows x Columns, column-major) of a function at a point.
template <std::size_t Rows, std::size_t Columns>
struct Linearization {
  std::array<double, Rows> value;
  std::array<double, Rows * Columns> jacobian;

  double derivative(std::size_t row, std::size_t column) const {
    return jacobian[column * Rows + row];
  }
};

/// The scalar that carries derivatives by N variables.
template <std::size_t N>
using Dual = ceres::Jet<double, static_cast<int>(N)>;

/// Sets `duals` to `values`, dual i being variable number `first + i` of N.
template <std::size_t N>
void seed_variables(std::span<const double> values, std::size_t first, std::span<Dual<N>> duals) {
  for (std::size_t i = 0; i < values.size(); ++i)
    duals[i] = Dual<N>(values[i], static_cast<int>(first + i));
}

/// Reads value and derivatives out of a function's results.
template <std::size_t Rows, std::size_t N>
void read_linearization(std::span<const Dual<N>, Rows> results, Linearization<Rows, N>& out) {
  for (std::size_t i = 0; i < Rows; ++i) {
    out.value[i] = results[i].a;
    for (std::size_t j = 0; j < N; ++j)
      out.jacobian[j * Rows + i] = results[i].v[static_cast<Eigen::Index>(j)];
  }
}

/// The number behind a scalar, for decisions that derivatives take no part in.
inline double scalar_value(double x) { return x; }
template <typename T, int N>
double scalar_value(const ceres::Jet<T, N>& x) {
  return scalar_value(x.a);
}

}  // namespace ilss
