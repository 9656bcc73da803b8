// Functions as modules: a closed formula, generic in the scalar, becomes a logical sensor whose
// errors propagate by automatic differentiation.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "framework/estimate/differentiate.h"
#include "framework/module/module_type.h"

namespace ilss {
namespace internal {

template <template <typename> class Payload>
constexpr bool has_rotation = std::any_of(Payload<double>::fields.begin(),
                                          Payload<double>::fields.end(), [](const Field& field) {
                                            return field.geometry == Geometry::rotation;
                                          });

template <template <typename> class Out, template <typename> class... In>
struct FormulaSignature {
  template <typename T>
  using Output = Out<T>;
  template <typename T>
  using Inputs = std::tuple<In<T>...>;
  static constexpr std::size_t arguments = sizeof...(In);
  static constexpr std::array<std::size_t, sizeof...(In)> dimensions = {dimension_of<In>...};
  static std::vector<const PayloadDescriptor*> descriptors() { return {&descriptor<In>()...}; }
  static const PayloadDescriptor& output() { return descriptor<Out>(); }
  static constexpr bool any_rotation = has_rotation<Out> || (has_rotation<In> || ...);
};

template <typename F, template <typename> class Out, template <typename> class... In>
FormulaSignature<Out, In...> signature_of(Outcome<Out<double>> (F::*)(const In<double>&...) const);

template <typename F>
using SignatureOf = decltype(signature_of(&F::template operator()<double>));

}  // namespace internal

/// Makes a module of F, a class with
///   static constexpr std::string_view name, description;
///   static constexpr std::array<std::string_view, n> inputs;        // their names
///   template <typename T> Outcome<Out<T>> operator()([const Parameters<T>&,] const In<T>&...)
///   const;
/// and optionally `Parameters`, `Options` (then constructed from them), `reference`, `faults`,
/// `static void set_frames(Interface&, const Options&)` (default: the first input's frame), and
/// `void jacobian(arguments as doubles..., const Out<double>& value, std::span<double> J) const`,
/// the exact derivatives by all arguments, parameters first (column-major), instead of automatic
/// ones.
template <typename F>
class FunctionModule final : public Module {
  using Signature = internal::SignatureOf<F>;
  using OutDouble = typename Signature::template Output<double>;
  static constexpr bool has_parameters = internal::HasParameters<F>;
  static constexpr std::size_t rows = OutDouble::fields.size();
  static constexpr std::size_t parameter_columns = has_parameters ? Signature::dimensions[0] : 0;
  static constexpr std::size_t all_columns = [] {
    std::size_t sum = 0;
    for (const std::size_t d : Signature::dimensions) sum += d;
    return sum;
  }();

 public:
  static constexpr std::size_t input_count = Signature::arguments - (has_parameters ? 1 : 0);

  static_assert(F::inputs.size() == input_count, "`inputs` names each input of the formula");

  explicit FunctionModule(F formula) : formula_(std::move(formula)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    bool any_error = false;
    for (std::size_t i = 0; i < input_count; ++i) any_error |= !evaluation.input(i).lineage.empty();
    return has_parameters && !evaluation.parameters.lineage.empty()
               ? evaluate_linearized<0>(evaluation, output)
           : any_error ? evaluate_linearized<parameter_columns>(evaluation, output)
                       : evaluate_value(evaluation, output);
  }

  /// The Jacobian by automatic differentiation, whatever the formula offers (rows x all arguments,
  /// parameters first, column-major): what an exact `jacobian` is held against.
  Outcome<Linearization<rows, all_columns>> differentiate(const Evaluation& evaluation) const {
    Linearization<rows, all_columns> result;
    auto value = call_with_duals<0>(evaluation);
    if (value.is_fault()) return value.fault();
    if (value.is_pending()) return Pending{};
    read_linearization<rows, all_columns>(components(std::as_const(*value)), result);
    return result;
  }

 private:
  /// The estimate behind argument a of the formula: the parameters, then the inputs.
  static const Estimate& argument(const Evaluation& evaluation, std::size_t a) {
    if constexpr (has_parameters) {
      if (a == 0) return evaluation.parameters;
      return evaluation.input(a - 1);
    } else {
      return evaluation.input(a);
    }
  }

  /// All arguments over scalar T; `fill(dual or double components, estimate, first column)`.
  template <typename T, typename Fill>
  static auto arguments(const Evaluation& evaluation, Fill fill) {
    typename Signature::template Inputs<T> tuple{};
    std::size_t a = 0;
    std::size_t column = 0;
    const auto read = [&](auto& payload) {
      const Estimate& estimate = argument(evaluation, a);
      const auto scalars = components(payload);
      fill(std::span<T>(scalars.data(), scalars.size()), estimate, column);
      if constexpr (requires { payload.label; })
        for (std::size_t i = 0; i < payload.label.size(); ++i)
          payload.label[i] = i < estimate.labels.size() ? estimate.labels[i] : 0;
      ++a;
      column += scalars.size();
    };
    std::apply([&](auto&... payloads) { (read(payloads), ...); }, tuple);
    return tuple;
  }

  auto double_arguments(const Evaluation& evaluation) const {
    return arguments<double>(evaluation,
                             [](std::span<double> out, const Estimate& in, std::size_t) {
                               for (std::size_t i = 0; i < out.size(); ++i) out[i] = in.value[i];
                             });
  }

  /// Calls the formula with derivatives by every argument column from `First` on.
  template <std::size_t First>
  auto call_with_duals(const Evaluation& evaluation) const {
    static constexpr std::size_t columns = all_columns - First;
    using T = Dual<columns>;
    const auto tuple =
        arguments<T>(evaluation, [](std::span<T> out, const Estimate& in, std::size_t column) {
          if (column >= First)
            return seed_variables<columns>(std::span<const double>(in.value.data(), out.size()),
                                           column - First, out);
          for (std::size_t i = 0; i < out.size(); ++i) out[i] = T(in.value[i]);
        });
    return std::apply([&](const auto&... payloads) { return formula_(payloads...); }, tuple);
  }

  Outcome<> evaluate_value(const Evaluation& evaluation, Output& output) const {
    auto value = std::apply([&](const auto&... payloads) { return formula_(payloads...); },
                            double_arguments(evaluation));
    if (value.is_fault()) return value.fault();
    if (value.is_pending()) return Pending{};
    const auto scalars = components(std::as_const(*value));
    output.estimate.value.assign(scalars.begin(), scalars.end());
    if constexpr (Signature::any_rotation) normalize(Signature::output(), output.estimate.value);
    output.estimate.lineage.reset(rows);
    copy_labels(*value, output);
    return check_finite(output);
  }

  template <std::size_t First>
  Outcome<> evaluate_linearized(const Evaluation& evaluation, Output& output) const {
    static constexpr std::size_t columns = all_columns - First;
    Linearization<rows, columns> linear;
    [[maybe_unused]] std::array<double, rows * all_columns> jacobian;
    const double* derivatives = linear.jacobian.data();
    if constexpr (requires(const OutDouble& value) { exact_jacobian(evaluation, value, {}); }) {
      auto value = std::apply([&](const auto&... payloads) { return formula_(payloads...); },
                              double_arguments(evaluation));
      if (value.is_fault()) return value.fault();
      if (value.is_pending()) return Pending{};
      exact_jacobian(evaluation, *value, jacobian);
      derivatives = jacobian.data() + rows * First;
      const auto scalars = components(std::as_const(*value));
      std::copy_n(scalars.begin(), rows, linear.value.begin());
      copy_labels(*value, output);
    } else {
      const auto value = call_with_duals<First>(evaluation);
      if (value.is_fault()) return value.fault();
      if (value.is_pending()) return Pending{};
      read_linearization<rows, columns>(components(*value), linear);
      copy_labels(*value, output);
    }
    output.estimate.value.assign(linear.value.begin(), linear.value.end());
    if constexpr (Signature::any_rotation) {
      if (derivatives != linear.jacobian.data())
        std::copy_n(derivatives, rows * columns, linear.jacobian.begin());
      derivatives = linear.jacobian.data();
      take_tangents<First>(evaluation, output.estimate, linear.jacobian);
    }
    std::array<LineageTerm, Signature::arguments> terms;
    std::size_t count = 0;
    std::size_t column = 0;
    for (std::size_t a = 0; a < Signature::arguments; ++a) {
      if (column >= First)
        terms[count++] = {derivatives + rows * (column - First), &argument(evaluation, a).lineage};
      column += Signature::dimensions[a];
    }
    if (evaluation.correlation_unknown) [[unlikely]]
      compose_bounded({terms.data(), count}, rows, evaluation.fresh(0), output.estimate.lineage);
    else
      compose({terms.data(), count}, rows, output.estimate.lineage);
    if (!std::isfinite(sum_of_squares(output.estimate.lineage)))
      return Fault{FaultKind::not_finite, all_finite({derivatives, rows * columns})
                                              ? "the result's error is not finite"
                                              : "the formula has no finite derivative here"};
    return check_finite(output);
  }

  auto exact_jacobian(const Evaluation& evaluation, const OutDouble& value,
                      std::span<double> jacobian) const requires requires(const F& f) {
    &F::jacobian;
  }
  {
    return std::apply(
        [&](const auto&... payloads) { formula_.jacobian(payloads..., value, jacobian); },
        double_arguments(evaluation));
  }

  /// Makes Jacobians by components those by errors, where a rotation's are not the same.
  template <std::size_t First>
  static void take_tangents(const Evaluation& evaluation, Estimate& result,
                            std::span<double> jacobian) {
    std::size_t column = 0;
    for (std::size_t a = 0; a < Signature::arguments; ++a) {
      const std::size_t count = Signature::dimensions[a];
      if (column >= First)
        jacobian_of_errors(Signature::output(), result.value, *Signature::descriptors()[a],
                           argument(evaluation, a).value,
                           jacobian.subspan(rows * (column - First), rows * count));
      column += count;
    }
    normalize(Signature::output(), result.value);
  }

  template <typename Payload>
  static void copy_labels([[maybe_unused]] const Payload& payload,
                          [[maybe_unused]] Output& output) {
    if constexpr (requires { payload.label; }) {
      for (std::size_t i = 0; i < payload.label.size(); ++i)
        if (static_cast<std::size_t>(payload.label[i]) >= Payload::labels[i].values.size())
          throw std::logic_error("the formula's label is none that its payload declares");
      output.estimate.labels.assign(payload.label.begin(), payload.label.end());
    }
  }

  /// Of all sensitivities, in four sums that do not wait for each other.
  static double sum_of_squares(const Lineage& lineage) {
    const std::span<const double> g(lineage.factor().data(), rows * lineage.size());
    std::array<double, 4> sums{};
    std::size_t i = 0;
    for (; i + 4 <= g.size(); i += 4)
      for (std::size_t lane = 0; lane < 4; ++lane) sums[lane] += g[i + lane] * g[i + lane];
    for (; i < g.size(); ++i) sums[0] += g[i] * g[i];
    return sums[0] + sums[1] + sums[2] + sums[3];
  }

  /// Without a branch an entry: infinities and NaNs turn the sum of zeros into NaN.
  static bool all_finite(std::span<const double> numbers) {
    double zero = 0;
    for (const double x : numbers) zero += 0 * x;
    return zero == 0;
  }

  static Outcome<> check_finite(const Output& output) {
    if (!all_finite(output.estimate.value))
      return Fault{FaultKind::not_finite, "the formula's result is not finite"};
    return {};
  }

  F formula_;
};

/// The type of a function module: see FunctionModule for what F must have.
template <typename F>
ModuleType function_type() {
  using Signature = internal::SignatureOf<F>;
  ModuleType type;
  internal::fill_declarations<F>(type);
  type.kind = ModuleKind::function;
  type.checked = true;
  type.interface = []([[maybe_unused]] const Settings& settings) {
    Interface interface;
    const auto payloads = Signature::descriptors();
    const std::size_t first = payloads.size() - F::inputs.size();
    for (std::size_t i = 0; i < F::inputs.size(); ++i)
      interface.inputs.push_back({std::string(F::inputs[i]), payloads[first + i], {}, false});
    interface.output = &Signature::output();
    if (!interface.inputs.empty()) interface.frame_of_input = 0;
    if constexpr (requires { &F::set_frames; }) {
      if constexpr (internal::HasOptions<F>)
        F::set_frames(interface, internal::options_of<F>(settings));
      else
        F::set_frames(interface);
    }
    return interface;
  };
  type.create = []([[maybe_unused]] const Settings& settings) -> std::unique_ptr<Module> {
    if constexpr (internal::HasOptions<F>)
      return std::make_unique<FunctionModule<F>>(F(internal::options_of<F>(settings)));
    else
      return std::make_unique<FunctionModule<F>>(F());
  };
  return type;
}

}  // namespace ilss
