// A running system: a plan's modules, their latest outputs, and the evaluation of one tick.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/folding.h"
#include "framework/graph/plan.h"

namespace ilss {

/// Which columns are joined when nothing else refers to them.
enum class Folding {
  none,
  per_owner,  ///< at most M columns an owner, so budgets survive
  all,        ///< at most M columns in all: the cheapest, where no budget is asked for
};

/// The state of one node after a tick.
struct NodeState {
  std::unique_ptr<Module> module;
  Outcome<> outcome = Pending{};
  std::optional<std::size_t> origin =
      {};                  ///< the node whose fault this is, where it came from above
  bool has_value = false;  ///< `output` holds one
  bool fresh = false;      ///< made in this tick
  Output output = {};      ///< the latest output; held while later ticks are pending

 private:
  friend class System;
  /// A connection: who gives the input, and how old it may be (s; infinite: as it likes).
  struct Feed {
    const NodeState* producer;
    double max_age;
  };
  std::vector<Feed> feeds_;
  std::vector<const Output*> inputs_;  ///< the feeds' outputs
  std::uint64_t seed_ = 0;
  std::uint32_t dimension_ = 0;    ///< of its payload, ...
  std::uint32_t label_count_ = 0;  ///< ... which the module is held to, ...
  bool is_checked_ = false;        ///< ... unless it is held to it where it is made
  bool correlation_unknown_ = false;
};

/// A plan's modules at work. Copies nothing of the plan, which must outlive it.
class System {
 public:
  /// Creates the modules; an exception in a constructor becomes the fault `internal` of that node
  /// at every tick. Each module's random numbers follow from `seed`, its name and the tick.
  System(const Plan& plan, std::uint64_t seed, Folding folding = Folding::per_owner);

  const Plan& plan() const { return *plan_; }
  const NodeState& node(std::size_t i) const { return nodes_[i]; }
  std::size_t size() const { return nodes_.size(); }
  std::int64_t ticks() const { return tick_; }

  /// Evaluates the next tick at `time` (s since the start; must not run backwards).
  void evaluate(double time);
  /// As above, and tells an observer: `begin_tick()`, `end_node(i)` after each node, `end_tick()`.
  template <typename Observer>
  void evaluate(double time, Observer& observer) {
    begin_tick(time);
    observer.begin_tick();
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      evaluate_node(i);
      observer.end_node(i);
    }
    observer.end_tick();
  }

  /// Evaluates for prediction: expected errors, nothing acquired. Nodes in `operating_points` take
  /// that value: with its own error where `has_error`, else with the module's expected error at it.
  /// Components that are NaN are the module's to say. Nodes that only feed such nodes are left
  /// pending.
  struct OperatingPoint {
    Output value;
    bool has_error = false;
  };
  void expect(const std::map<std::size_t, OperatingPoint>& operating_points);

  /// Gives a module a command between ticks.
  Outcome<> command(std::size_t node, const Command& command);

  /// What a module has to say of its data, as Module::note.
  std::string note(std::size_t node) const;

  /// Runs a module's embedded tests.
  std::vector<TestReport> run_tests(std::size_t node);

 private:
  void begin_tick(double time);
  void evaluate_node(std::size_t i);
  bool take_inputs(std::size_t i);
  void inherit_fault(std::size_t i);
  void report_stale(std::size_t i);
  Evaluation evaluation(std::size_t i) const;
  template <typename Call>
  void call_module(std::size_t i, Call call);
  void fold(std::size_t i);
  Outcome<> take_operating_point(std::size_t i, const OperatingPoint& point);
  [[gnu::noinline, gnu::cold]] void reject_output(std::size_t i);
  bool worth_folding(std::size_t i) const;
  bool foldable(std::size_t i, const Source& source) const {
    // Of this tick only: what a held value brings along is in outputs of earlier ticks, too.
    return source.tick == tick_ - 1 && source.owner < nodes_.size() &&
           post_dominators_.post_dominates(i, source.owner);
  }

  const Plan* plan_;
  Folding folding_;
  PostDominators post_dominators_;
  std::vector<NodeState> nodes_;
  std::int64_t tick_ = 0;
  double time_ = 0;
  std::uint64_t tick_seed_ = 0;
};

}  // namespace ilss
