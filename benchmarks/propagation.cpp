// What carrying errors along costs: a function module with lineage, and compose on its own.
#include <benchmark/benchmark.h>

#include <array>
#include <vector>

#include "framework/module/function_module.h"

namespace ilss {
namespace {

template <typename T>
struct Triple {
  T a, b, c;
  static constexpr std::string_view name = "triple";
  static constexpr auto fields = Fields{{"a", "m"}, {"b", "m"}, {"c", "m"}};
};

/// Three components of three.
struct Products {
  static constexpr std::string_view name = "products", description = "pairwise products";
  static constexpr std::array<std::string_view, 1> inputs = {"in"};
  template <typename T>
  Outcome<Triple<T>> operator()(const Triple<T>& in) const {
    return Triple<T>{in.a * in.b, in.b * in.c + in.a, in.c * in.a - in.b};
  }
};

/// The same with an exact Jacobian.
struct ProductsWithJacobian : Products {
  void jacobian(const Triple<double>& in, const Triple<double>&, std::span<double> out) const {
    const double columns[] = {in.b, 1, in.c, in.a, in.c, -1, 0, in.b, in.a};
    std::copy_n(columns, 9, out.begin());
  }
};

/// The same, scaled by a parameter.
struct ScaledProducts {
  static constexpr std::string_view name = "scaled", description = "pairwise products, scaled";
  static constexpr std::array<std::string_view, 1> inputs = {"in"};
  template <typename T>
  struct Parameters {
    T scale;
    static constexpr std::string_view name = "scale";
    static constexpr auto fields = Fields{{"scale", "1"}};
  };
  template <typename T>
  Outcome<Triple<T>> operator()(const Parameters<T>& p, const Triple<T>& in) const {
    return Triple<T>{p.scale * (in.a * in.b), p.scale * (in.b * in.c + in.a),
                     p.scale * (in.c * in.a - in.b)};
  }
};

/// Random columns of `count` sources of one owner, every `stride`-th from `first` on.
Lineage random_lineage(std::size_t dimension, std::uint32_t count, std::uint32_t first = 0,
                       std::uint32_t stride = 1) {
  RandomBits bits(dimension * 1000 + count);
  Lineage lineage(dimension);
  std::vector<double> column(dimension);
  for (std::uint32_t k = 0; k < count; ++k) {
    for (double& x : column) x = draw_normal(bits);
    lineage.add({0, first + k * stride, 0}, column);
  }
  return lineage;
}

template <typename F>
void evaluate(benchmark::State& state, const Estimate& parameters, std::uint32_t sources) {
  FunctionModule<F> module{F{}};
  Output input;
  input.estimate = Estimate(descriptor<Triple>());
  input.estimate.value = {1.5, 2.5, 3.5};
  input.estimate.lineage = random_lineage(3, sources);
  const Output* inputs[] = {&input};
  Output output;
  output.estimate = Estimate(descriptor<Triple>());
  const Evaluation evaluation{.parameters = parameters, .inputs = inputs};
  for (auto _ : state) {
    auto outcome = module.evaluate(evaluation, output);
    benchmark::DoNotOptimize(outcome);
    benchmark::DoNotOptimize(output.estimate.value.data());
    benchmark::ClobberMemory();
  }
}

void function_without_error(benchmark::State& state) { evaluate<Products>(state, Estimate{}, 0); }
void function_8_sources(benchmark::State& state) { evaluate<Products>(state, Estimate{}, 8); }
void function_8_sources_exact_jacobian(benchmark::State& state) {
  evaluate<ProductsWithJacobian>(state, Estimate{}, 8);
}
void function_8_sources_exact_parameter(benchmark::State& state) {
  Estimate parameters(descriptor<ScaledProducts::Parameters>());
  parameters.value = {2};
  evaluate<ScaledProducts>(state, parameters, 8);
}
void function_8_sources_uncertain_parameter(benchmark::State& state) {
  Estimate parameters(descriptor<ScaledProducts::Parameters>());
  parameters.value = {2};
  parameters.lineage.add({1, 0, persistent_tick}, 0, 0.1);
  evaluate<ScaledProducts>(state, parameters, 8);
}
BENCHMARK(function_without_error);
BENCHMARK(function_8_sources);
BENCHMARK(function_8_sources_exact_jacobian);
BENCHMARK(function_8_sources_exact_parameter);
BENCHMARK(function_8_sources_uncertain_parameter);

/// 6 x 6 Jacobians; `terms` lineages of 32 sources in all, every other one shared where there are
/// two. The second argument says whether the covariance is computed, too.
void compose_6x6_32_sources(benchmark::State& state) {
  const auto terms = static_cast<std::size_t>(state.range(0));
  const bool with_covariance = state.range(1) != 0;
  std::vector<Lineage> lineages;
  if (terms == 1)
    lineages = {random_lineage(6, 32)};
  else
    lineages = {random_lineage(6, 16, 0, 2), random_lineage(6, 24, 8, 1)};
  const Lineage jacobian = random_lineage(6, 6);
  std::vector<LineageTerm> list;
  for (const Lineage& lineage : lineages) list.push_back({jacobian.factor().data(), &lineage});
  Lineage out;
  Eigen::MatrixXd covariance(6, 6);
  for (auto _ : state) {
    compose(list, 6, out);
    if (with_covariance) out.covariance(covariance);
    benchmark::DoNotOptimize(covariance.data());
    benchmark::DoNotOptimize(out.column(0).data());
    benchmark::ClobberMemory();
  }
  state.counters["sources"] = static_cast<double>(out.size());
}
BENCHMARK(compose_6x6_32_sources)->ArgNames({"terms", "covariance"})->ArgsProduct({{1, 2}, {0, 1}});

}  // namespace
}  // namespace ilss
