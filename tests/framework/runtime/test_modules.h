// Small modules and graphs that the runtime's tests run: each does one thing that a test watches.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "framework/graph/plan.h"
#include "framework/module/registry.h"

namespace ilss::runtime_test {

template <typename T>
struct Number {
  T value;
  static constexpr std::string_view name = "number";
  static constexpr auto fields = Fields{{"value", "1"}};
};

/// Counts its own evaluations; due every `period` ticks from `first` on, with noise where `std` is
/// given.
class Counter final : public Module {
 public:
  static constexpr std::string_view name = "counter";
  static constexpr std::string_view description = "Counts its evaluations";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    std::int64_t period = 1;
    std::int64_t first = 0;
    std::int64_t fault_at = -1;
    double delay = 0;
    double std = 0;
    std::int64_t parts = 1;
    void declare(OptionVisitor& visit) {
      visit("period", period, "Ticks from one output to the next");
      visit("first", first, "The first tick at which it is due");
      visit("fault_at", fault_at, "The tick at which it detects nothing");
      visit("delay", delay, "Age of the data", {.unit = "s"});
      visit("std", std, "Noise");
      visit("parts", parts, "Independent parts of the noise", {.minimum = 1});
    }
  };
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  explicit Counter(const Options& options) : options_(options) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    if (evaluation.tick == options_.fault_at) return Fault{FaultKind::no_detection, "nothing"};
    if (evaluation.tick < options_.first || evaluation.tick % options_.period != 0)
      return Pending{};
    const double noise =
        options_.std * static_cast<double>(evaluation.random()() >> 32U) / 4294967296.0;
    assign<Number>(output.estimate, {static_cast<double>(++count_) + noise});
    const double part = options_.std / std::sqrt(static_cast<double>(options_.parts));
    for (std::uint32_t k = 0; options_.std > 0 && k < options_.parts; ++k)
      output.estimate.lineage.add(evaluation.fresh(k), 0, part);
    output.acquired = Acquisition::at(evaluation.time - duration_of(options_.delay));
    return {};
  }

 private:
  Options options_;
  std::int64_t count_ = 0;
};

/// Throws where it is told to.
class Thrower final : public Module {
 public:
  static constexpr std::string_view name = "thrower";
  static constexpr std::string_view description = "Throws";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    bool early = false;
    bool odd = false;
    void declare(OptionVisitor& visit) {
      visit("early", early, "Throw in the constructor");
      visit("odd", odd, "Throw what is no std::exception");
    }
  };
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  explicit Thrower(const Options& options) : odd_(options.odd) {
    if (options.early) throw std::runtime_error("no such device");
  }
  Outcome<> evaluate(const Evaluation&, Output&) override {
    if (odd_) throw 42;
    throw std::runtime_error("out of luck");
  }

 private:
  bool odd_;
};

/// Gives the number that commands made: set, added to or left by a text. Refuses to be set below
/// zero, and throws above 999.
class Dial final : public Module {
 public:
  static constexpr std::string_view name = "dial";
  static constexpr std::string_view description = "Gives the number that it was told";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    bool broken = false;
    void declare(OptionVisitor& visit) { visit("broken", broken, "Throw in the constructor"); }
  };
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  static std::vector<CommandDeclaration> commands() {
    return {number_command("set", "sets the number"), number_command("add", "adds to the number"),
            text_command("text", "changes nothing"),
            number_command("time", "sets the number to the time of the command")};
  }
  explicit Dial(const Options& options) {
    if (options.broken) throw std::runtime_error("no such dial");
  }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    assign<Number>(output.estimate, {value_});
    return {};
  }
  Outcome<> command(const Command& command) override {
    if (command.name == "text") return {};
    if (command.name == "time") {
      value_ = seconds(command.time);
      return {};
    }
    const double value = std::get<double>(command.value);
    if (command.name == "add") {
      value_ += value;
      return {};
    }
    if (value > 999) throw std::runtime_error("stuck");
    if (value < 0) return Fault{FaultKind::refused, "below zero"};
    value_ = value;
    return {};
  }

 private:
  double value_ = 0;
};

struct Increment {
  static constexpr std::string_view name = "increment";
  static constexpr std::string_view description = "Adds a step";
  static constexpr std::array<std::string_view, 1> inputs = {"number"};
  template <typename T>
  struct Parameters {
    T step;
    static constexpr std::string_view name = "increment_parameters";
    static constexpr auto fields = Fields{{"step", "1", "What to add", 1.0}};
  };
  template <typename T>
  Outcome<Number<T>> operator()(const Parameters<T>& parameters, const Number<T>& x) const {
    return Number<T>{x.value + parameters.step};
  }
};

struct Subtract {
  static constexpr std::string_view name = "subtract";
  static constexpr std::string_view description = "The difference of two numbers";
  static constexpr std::array<std::string_view, 2> inputs = {"left", "right"};
  template <typename T>
  Outcome<Number<T>> operator()(const Number<T>& left, const Number<T>& right) const {
    return Number<T>{left.value - right.value};
  }
};

/// The sum of any number of inputs, with their sources.
class Sum final : public Module {
 public:
  static constexpr std::string_view name = "sum";
  static constexpr std::string_view description = "The sum of its inputs";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static Interface interface() {
    return {{{"numbers", &descriptor<Number>(), {}, true}}, &descriptor<Number>(), {}, 0};
  }
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    Number<double> sum{0};
    terms_.clear();
    for (std::size_t i = 0; i < evaluation.inputs.size(); ++i) {
      sum.value += evaluation.input(i).value[0];
      terms_.push_back({&one_, &evaluation.input(i).lineage});
    }
    assign<Number>(output.estimate, sum);
    compose(terms_, 1, output.estimate.lineage);
    return {};
  }

 private:
  double one_ = 1;
  std::vector<LineageTerm> terms_;
};

/// Selects the branch whose number is the tick's, in turn; `cautious` ones first look at all.
class Switch final : public Selector {
 public:
  static constexpr std::string_view name = "switch";
  static constexpr std::string_view description = "One input after another";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  struct Options {
    bool cautious = false;
    std::int64_t stuck_at = -1;
    void declare(OptionVisitor& visit) {
      visit("cautious", cautious, "Evaluate all branches");
      visit("stuck_at", stuck_at, "Select this branch at every tick");
    }
  };
  static Interface interface() {
    return {{{"numbers", &descriptor<Number>(), {}, true}}, &descriptor<Number>(), {}, 0};
  }
  explicit Switch(const Options& options) : options_(options) {}
  Outcome<std::size_t> select(const Evaluation& evaluation, Branches& branches) override {
    if (options_.cautious)
      for (std::size_t k = 0; k < branches.size(); ++k) branches.evaluate(k);
    const std::size_t wanted = options_.stuck_at >= 0
                                   ? static_cast<std::size_t>(options_.stuck_at)
                                   : static_cast<std::size_t>(evaluation.tick) % branches.size();
    if (wanted < branches.size()) branches.evaluate(wanted);
    return wanted;
  }

 private:
  Options options_;
};

/// A number from a file that may not open, with times of its own: `step` apart from `from` on.
class Archive final : public Module {
 public:
  static constexpr std::string_view name = "archive";
  static constexpr std::string_view description = "Numbers with times";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    bool lost = false;
    bool throws = false;
    std::int64_t count = 3;
    double from = 100;
    double step = 1;
    void declare(OptionVisitor& visit) {
      visit("lost", lost, "It cannot be opened");
      visit("throws", throws, "Opening it throws");
      visit("count", count, "How many numbers it has");
      visit("from", from, "The first one's time", {.unit = "s"});
      visit("step", step, "From one to the next", {.unit = "s"});
    }
  };
  static inline int open_now = 0;  ///< how many are open
  static Interface interface() { return {{}, &descriptor<Number>(), "robot", {}}; }
  explicit Archive(const Options& options) : options_(options) {}
  Outcome<> open() override {
    if (options_.throws) throw std::runtime_error("the shelf is empty");
    if (options_.lost) return Fault{FaultKind::device_lost, "no such archive"};
    if (!is_open_) ++open_now;
    is_open_ = true;
    return {};
  }
  void close() override {
    if (is_open_) --open_now;
    is_open_ = false;
  }
  std::optional<Time> next_time() override {
    if (given_ == options_.count) return std::nullopt;
    return time_at(options_.from + options_.step * static_cast<double>(given_));
  }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    if (!is_open_) return Fault{FaultKind::internal, "evaluated while it is closed"};
    if (given_ == options_.count) return Fault{FaultKind::end_of_data, "no more numbers"};
    assign<Number>(output.estimate, {static_cast<double>(++given_)});
    return {};
  }

 private:
  Options options_;
  bool is_open_ = false;
  std::int64_t given_ = 0;
};

const Registry& registry();

/// The plan of a graph's text; what is wrong with it fails the test.
Plan plan_of(const std::string& text);

}  // namespace ilss::runtime_test
