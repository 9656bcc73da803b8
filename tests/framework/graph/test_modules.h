// Small modules for tests of the framework, which must not depend on sensors: readings with errors,
// and formulas whose derivatives can be written down.
#pragma once

#include <cmath>

#include "framework/module/registry.h"

namespace ilss::test {

template <typename T>
struct Scalar {
  T x;
  static constexpr std::string_view name = "scalar";
  static constexpr auto fields = Fields{{"x", "m", "a length"}};
};

template <typename T>
struct Pair {
  T a, b;
  static constexpr std::string_view name = "pair";
  static constexpr auto fields = Fields{{"a", "m", "a length"}, {"b", "m", "another", 2.0}};
};

inline constexpr std::string_view turn_sides[] = {"left", "right"};
inline constexpr LabelField turn_labels[] = {{"side", turn_sides}};

template <typename T>
struct Turn {
  T angle, ratio;
  std::array<int, 1> label{};
  static constexpr std::string_view name = "turn";
  static constexpr auto fields =
      Fields{{"angle", "rad", "", required, Geometry::circular}, {"ratio", "1", "", 1.0}};
  static constexpr std::span<const LabelField> labels = turn_labels;
};

enum class Distribution { normal, none };
inline constexpr std::array<std::string_view, 2> choices(Distribution) {
  return {"normal", "none"};
}

/// A length as if read: value + bias, with noise where `noise: normal`; pending between `period`s.
class Reading final : public Module {
 public:
  static constexpr std::string_view name = "reading";
  static constexpr std::string_view description = "a length as if read";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::end_of_data};
  template <typename T>
  struct Parameters {
    T bias, mount_x;
    static constexpr std::string_view name = "reading_parameters";
    static constexpr auto fields =
        Fields{{"bias", "m", "added to every reading", 0}, {"mount.x", "m", "added, too", 0}};
  };
  struct Options {
    double value = 1;
    double value_std = 0;
    Distribution noise = Distribution::none;
    std::int64_t period = 1;
    std::string frame;
    std::vector<std::int64_t> skipped;
    void declare(OptionVisitor& visit) {
      visit("value", value, "what is read", {.unit = "m"});
      visit("value_std", value_std, "its sd", {.unit = "m", .minimum = 0});
      visit("noise", noise, "how values scatter");
      visit("period", period, "ticks between readings", {.minimum = 1});
      visit("frame", frame, "the frame");
      visit("skipped", skipped, "ticks of no reading");
    }
  };
  static Interface interface(const Options& options) {
    return {{}, &descriptor<Scalar>(), options.frame, {}};
  }
  explicit Reading(Options options) : options_(std::move(options)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    if (evaluation.tick % options_.period != 0) return Pending{};
    for (const std::int64_t skipped : options_.skipped)
      if (skipped == evaluation.tick) return Fault{FaultKind::no_detection, "skipped"};
    double x = options_.value;
    RandomBits random = evaluation.random();
    if (options_.noise == Distribution::normal) x += options_.value_std * draw_normal(random);
    return emit(evaluation, x, output);
  }
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override {
    const double x = operating_point ? operating_point->estimate.value[0] : options_.value;
    return emit(evaluation, x, output);
  }

 private:
  Outcome<> emit(const Evaluation& evaluation, double x, Output& output) const {
    const Estimate& p = evaluation.parameters;
    const std::array<double, 2> ones = {1, 1};
    const LineageTerm term{ones.data(), &p.lineage};
    compose({&term, 1}, 1, output.estimate.lineage);
    output.estimate.value.assign(1, x + p.value[0] + p.value[1]);
    if (options_.value_std > 0)
      output.estimate.lineage.add(evaluation.fresh(0), std::size_t{0}, options_.value_std);
    return {};
  }
  Options options_;
};

/// Two lengths whose noise is correlated: sd 1 mm and 2 mm, correlation 0.6.
class PairReading final : public Module {
 public:
  static constexpr std::string_view name = "pair_reading";
  static constexpr std::string_view description = "two lengths of correlated noise";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    double a = 1;
    double b = 2;
    void declare(OptionVisitor& visit) {
      visit("a", a, "the first", {.unit = "m"});
      visit("b", b, "the second", {.unit = "m"});
    }
  };
  static Interface interface() { return {{}, &descriptor<Pair>(), "", {}}; }
  explicit PairReading(Options options) : options_(options) {}
  static Eigen::Matrix2d noise() {
    return (Eigen::Matrix2d() << 1e-6, 1.2e-6, 1.2e-6, 4e-6).finished();
  }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.estimate.value = {options_.a, options_.b};
    output.estimate.lineage.reset(2);
    output.estimate.lineage.add_noise(evaluation.fresh(0), noise());
    return {};
  }

 private:
  Options options_;
};

struct Add {
  static constexpr std::string_view name = "add", description = "a + b";
  static constexpr std::array<std::string_view, 2> inputs = {"a", "b"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a, const Scalar<T>& b) const {
    return Scalar<T>{a.x + b.x};
  }
};

struct Subtract {
  static constexpr std::string_view name = "subtract", description = "a - b";
  static constexpr std::array<std::string_view, 2> inputs = {"a", "b"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a, const Scalar<T>& b) const {
    return Scalar<T>{a.x - b.x};
  }
};

struct Product {
  static constexpr std::string_view name = "product", description = "a b, in m x 1 m";
  static constexpr std::array<std::string_view, 2> inputs = {"a", "b"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a, const Scalar<T>& b) const {
    return Scalar<T>{a.x * b.x};
  }
};

struct Sine {
  static constexpr std::string_view name = "sine", description = "sin(x / 1 m) x 1 m";
  static constexpr std::array<std::string_view, 1> inputs = {"x"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a) const {
    using std::sin;
    return Scalar<T>{sin(a.x)};
  }
};

struct Root {
  static constexpr std::string_view name = "root", description = "the square root";
  static constexpr std::array<std::string_view, 1> inputs = {"x"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a) const {
    using std::sqrt;
    if (!(a.x > T(0))) return Fault{FaultKind::out_of_range, "not positive"};
    return Scalar<T>{sqrt(a.x)};
  }
};

struct Magnitude {
  static constexpr std::string_view name = "magnitude", description = "|x|, a kink at 0";
  static constexpr std::array<std::string_view, 1> inputs = {"x"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a) const {
    return Scalar<T>{a.x < T(0) ? -a.x : a.x};
  }
};

struct Gain {
  static constexpr std::string_view name = "gain", description = "gain x + offset";
  static constexpr std::array<std::string_view, 1> inputs = {"x"};
  template <typename T>
  struct Parameters {
    T gain, offset;
    static constexpr std::string_view name = "gain_parameters";
    static constexpr auto fields = Fields{{"gain", "1", "factor"}, {"offset", "m", "added", 0}};
  };
  template <typename T>
  Outcome<Scalar<T>> operator()(const Parameters<T>& p, const Scalar<T>& a) const {
    return Scalar<T>{p.gain * a.x + p.offset};
  }
};

struct Join {
  static constexpr std::string_view name = "join", description = "two scalars as a pair";
  static constexpr std::array<std::string_view, 2> inputs = {"a", "b"};
  template <typename T>
  Outcome<Pair<T>> operator()(const Scalar<T>& a, const Scalar<T>& b) const {
    return Pair<T>{a.x, b.x};
  }
};

struct Mix {
  static constexpr std::string_view name = "mix", description = "two pairs to one, nonlinear";
  static constexpr std::array<std::string_view, 2> inputs = {"p", "q"};
  template <typename T>
  Outcome<Pair<T>> operator()(const Pair<T>& p, const Pair<T>& q) const {
    using std::sin;
    return Pair<T>{p.a * q.b, p.b + sin(q.a)};
  }
};

struct Collapse {
  static constexpr std::string_view name = "collapse", description = "a + b / 2 of a pair";
  static constexpr std::array<std::string_view, 1> inputs = {"p"};
  template <typename T>
  Outcome<Scalar<T>> operator()(const Pair<T>& p) const {
    return Scalar<T>{p.a + 0.5 * p.b};
  }
};

/// From frame "here" to frame "there".
struct Carry {
  static constexpr std::string_view name = "carry", description = "from here to there";
  static constexpr std::array<std::string_view, 1> inputs = {"x"};
  static void set_frames(Interface& interface) {
    interface.inputs[0].frame = "here";
    interface.frame = "there";
    interface.frame_of_input.reset();
  }
  template <typename T>
  Outcome<Scalar<T>> operator()(const Scalar<T>& a) const {
    return a;
  }
};

/// The sum of one or more scalars.
class Total final : public Module {
 public:
  static constexpr std::string_view name = "total";
  static constexpr std::string_view description = "sum of one or more";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static Interface interface() {
    return {{{"terms", &descriptor<Scalar>(), "", true}}, &descriptor<Scalar>(), "", 0};
  }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    const double one = 1;
    std::vector<LineageTerm> terms;
    double sum = 0;
    for (const Output* input : evaluation.inputs) {
      sum += input->estimate.value[0];
      terms.push_back({&one, &input->estimate.lineage});
    }
    output.estimate.value.assign(1, sum);
    compose(terms, 1, output.estimate.lineage);
    return {};
  }
};

/// Shows that parameters, choices and angles are read: angle and ratio as given.
class TurnReading final : public Module {
 public:
  static constexpr std::string_view name = "turn_reading";
  static constexpr std::string_view description = "an angle as given";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  template <typename T>
  struct Parameters {
    T angle;
    static constexpr std::string_view name = "turn_parameters";
    static constexpr auto fields =
        Fields{{"angle", "rad", "as given", required, Geometry::circular}};
  };
  static Interface interface() { return {{}, &descriptor<Turn>(), "here", {}}; }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.estimate.value = {evaluation.parameters.value[0], 1.0};
    const std::array<double, 2> jacobian = {1, 0};
    const LineageTerm term{jacobian.data(), &evaluation.parameters.lineage};
    compose({&term, 1}, 2, output.estimate.lineage);
    return {};
  }
};

/// Stands at the angle that it was last told, at most a right angle either way.
class Head final : public Module {
 public:
  static constexpr std::string_view name = "head";
  static constexpr std::string_view description = "stands where it is told";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<Turn>(), "here", {}}; }
  static std::vector<CommandDeclaration> commands() {
    return {quantity_command("rotate_to", "rad", "turns to this angle"),
            quantity_command("rotate_at", "rad/s", "turns at this rate"),
            number_command("zoom", "how near to look"),
            integer_command("sweeps", "how often to sweep"),
            boolean_command("light", "whether to light up"),
            text_command("label", "what to call it"),
            choice_command("mode", {"near", "far"}, "how far to look")};
  }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    assign<Turn>(output.estimate, {angle_, 1.0, {}});
    return {};
  }
  Outcome<> command(const Command& command) override {
    if (command.name != "rotate_to") return Fault{FaultKind::refused, "not now"};
    const double angle = std::get<double>(command.value);
    if (std::abs(angle) > std::acos(0.0)) return Fault{FaultKind::refused, "too far"};
    angle_ = angle;
    return {};
  }

 private:
  double angle_ = 0;
};

/// All of these.
const Registry& registry();

}  // namespace ilss::test
