// A running system: a plan's modules, their latest outputs, and the evaluation of one tick.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/folding.h"
#include "framework/graph/plan.h"
#include "framework/graph/regions.h"
#include "framework/graph/stand_in.h"

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
      {};                    ///< the node whose fault this is, where it came from above
  bool has_value = false;    ///< `output()` holds one
  bool fresh = false;        ///< made in this tick
  std::size_t selected = 0;  ///< of a selector: the input that `output()` is

  NodeState() = default;
  NodeState(const NodeState&) = delete;  // others hold where its output is
  NodeState& operator=(const NodeState&) = delete;

  /// The latest output; held while later ticks are pending. Of a selector: what it has selected,
  /// where that is.
  const Output& output() const { return *current_; }

 private:
  friend class System;
  /// A connection: who gives the input, and how old it may be.
  struct Feed {
    const NodeState* producer;
    Duration max_age;
  };
  Output own_ = {};
  const Output* current_ = &own_;
  std::vector<Feed> feeds_;
  std::vector<const Output*> inputs_;     ///< the feeds' outputs
  std::optional<Evaluation> evaluation_;  ///< what its module may know; the tick's part is set anew
  std::uint64_t seed_ = 0;
  enum class Check : std::uint8_t { nothing, parts, all };
  Check check_ = Check::all;  ///< of what the module gives: estimates may be checked as they
                              ///< are made, parts are samples and elements
  bool is_given_ = false;
  bool is_own_type_ = true;  ///< nothing stands in for it
  bool is_plain_ = true;     ///< takes inputs and evaluates, nothing else
  bool selects_ = false;
  bool reads_selectors_ = false;     ///< what feeds it may be another's output in every tick
  bool has_data_clock_ = false;      ///< and follows it
  std::int64_t evaluated_tick_ = 0;  ///< of a node on demand: the last one, counted from 1
};

/// How a system is put together.
struct SystemOptions {
  Folding folding = Folding::per_owner;
  StandIns stand_ins = {};  ///< who takes which module's place; may be empty
  /// Sources that know when their data were acquired are pending until that time has come.
  bool follow_data = false;
};

/// A module that could not be opened, and why.
struct OpenFault {
  std::size_t node;
  Fault fault;
};

/// Told of a tick's nodes while they are evaluated.
class NodeObserver {
 public:
  virtual ~NodeObserver() = default;
  /// A node is done: evaluated, or found to have nothing to do.
  virtual void end_node(std::size_t node) = 0;
};

/// A plan's modules at work. Copies nothing of the plan, which must outlive it.
class System {
 public:
  /// Creates the modules; an exception in a constructor becomes the fault `internal` of that node
  /// at every tick. Each module's random numbers follow from `seed`, its name and the tick.
  System(const Plan& plan, std::uint64_t seed, SystemOptions options);
  System(const Plan& plan, std::uint64_t seed, Folding folding = Folding::per_owner)
      : System(plan, seed, SystemOptions{.folding = folding}) {}
  /// Closes the modules.
  ~System();

  System(const System&) = delete;
  System& operator=(const System&) = delete;

  const Plan& plan() const { return *plan_; }
  const Regions& regions() const { return regions_; }
  const NodeState& node(std::size_t i) const { return nodes_[i]; }
  std::size_t size() const { return nodes_.size(); }
  std::int64_t ticks() const { return tick_; }
  Time time() const { return time_; }  ///< of the last tick
  /// Whether a node's output comes from outside.
  bool is_given(std::size_t node) const { return nodes_[node].is_given_; }
  /// Whether no selector asked for a node in this tick: what it has is of an earlier one.
  bool is_left_out(std::size_t node) const {
    return !regions_.is_always(node) && nodes_[node].evaluated_tick_ != tick_;
  }

  /// Opens what the modules read, once. One that cannot be opened, or throws, gives that fault at
  /// every tick. The first tick opens what nobody has opened.
  std::vector<OpenFault> open();

  /// Evaluates the next tick (times must not run backwards).
  void evaluate(Time time);
  /// As above, and tells an observer: `begin_tick()`, `end_node(i)` after each node that has its
  /// turn, `end_tick()`.
  template <typename Observer>
  void evaluate(Time time, Observer& observer) {
    begin_tick(time);
    observer.begin_tick();
    for (const std::size_t i : regions_.always()) {
      evaluate_node(i, &observer);
      observer.end_node(i);
    }
    observer.end_tick();
  }

  /// The same in parts, for whoever decides on the order: `begin_tick`, then `evaluate_node` for
  /// every node of `regions().always()`, each after what feeds it and what feeds its branches;
  /// nodes that do not depend on each other may be evaluated by several threads at once.
  void begin_tick(Time time);
  void evaluate_node(std::size_t i, NodeObserver* observer = nullptr);

  /// When the next data of any source were acquired, by their own clocks: when a run that follows
  /// its data has its next tick. Nothing where no source has such a clock, or all are at their end.
  std::optional<Time> next_data_time();

  /// Evaluates for prediction: expected errors, nothing acquired.
  void expect();

  /// Gives a module a command between ticks.
  Outcome<> command(std::size_t node, const Command& command);

  /// What a module has to say of its data, as Module::note.
  std::string note(std::size_t node) const;

  /// Runs a module's embedded tests.
  std::vector<TestReport> run_tests(std::size_t node);

 private:
  class BranchesOf;

  void connect(std::size_t i);
  void connect_inputs(std::size_t i);
  void start_tick(Time time);
  bool take_inputs(std::size_t i, bool& correlation_unknown);
  void find_inputs(std::size_t i);
  void inherit_fault(std::size_t i);
  void report_stale(std::size_t i);
  const Evaluation& evaluation(std::size_t i);
  template <typename Call>
  void call_module(std::size_t i, Call call);
  template <typename Call>
  Outcome<> carry(std::size_t i, Call call);
  [[gnu::noinline]] void evaluate_specially(std::size_t i, NodeObserver* observer);
  bool keeps_contract(std::size_t i) const;
  [[gnu::noinline]] bool passes_check(std::size_t i) const;
  void fold(std::size_t i);
  [[gnu::noinline]] void select(std::size_t i, NodeObserver* observer);
  bool awaits_data(std::size_t i);
  [[gnu::noinline, gnu::cold]] void reject_output(std::size_t i);
  bool worth_folding(std::size_t i) const;
  bool foldable(std::size_t i, const Source& source) const {
    // Of this tick only: what a held value brings along is in outputs of earlier ticks, too.
    return source.tick == tick_ - 1 && source.owner < nodes_.size() &&
           post_dominators_.post_dominates(i, source.owner);
  }

  const Plan* plan_;
  Folding folding_;
  bool follow_data_;
  PostDominators post_dominators_;
  std::vector<NodeState> nodes_;
  Regions regions_;
  std::int64_t tick_ = 0;
  Time time_ = {};
  std::uint64_t tick_seed_ = 0;
  bool is_open_ = false;
  bool expects_ = false;  ///< this tick is a prediction
};

}  // namespace ilss
