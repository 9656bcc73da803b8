#include "framework/graph/system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/graph/guarded.h"
#include "framework/module/carried_correlation.h"
#include "framework/module/contract.h"

namespace ilss {
namespace {

/// Stands for a selector that cannot be made, or not be opened.
class BrokenSelector final : public Selector {
 public:
  explicit BrokenSelector(Fault fault) : fault_(std::move(fault)) {}
  Outcome<> open() override { return fault_; }
  Outcome<std::size_t> select(const Evaluation&, Branches&) override { return fault_; }
  Outcome<> command(const Command&) override { return fault_; }

 private:
  Fault fault_;
};

/// The same of any other module.
class BrokenModule final : public Module {
 public:
  explicit BrokenModule(Fault fault) : fault_(std::move(fault)) {}
  Outcome<> open() override { return fault_; }
  Outcome<> evaluate(const Evaluation&, Output&) override { return fault_; }
  Outcome<> command(const Command&) override { return fault_; }

 private:
  Fault fault_;
};

std::unique_ptr<Module> broken(const PlanNode& node, Fault fault) {
  if (node.type->selects) return std::make_unique<BrokenSelector>(std::move(fault));
  return std::make_unique<BrokenModule>(std::move(fault));
}

/// Makes a node's module, or what stands in for it; `is_own` says which.
StandIn make_module(std::size_t index, const PlanNode& node, const StandIns& stand_ins,
                    bool& is_own) {
  is_own = false;
  std::string reason = "cannot be created";
  try {
    StandIn made = stand_ins ? stand_ins(index, node) : StandIn{};
    if (made.module == nullptr) {
      made.module = node.type->create(node.settings);
      is_own = true;
    }
    if (!node.type->selects || made.is_given || dynamic_cast<Selector*>(made.module.get()))
      return made;
    reason = "what stands in for a selector must be one, or be given";
  } catch (const std::exception& error) {
    reason += fmt::format(": {}", error.what());
  } catch (...) {
  }
  return {broken(node, {FaultKind::internal, std::move(reason)})};
}

}  // namespace

/// A selector's inputs, evaluated when it asks for them.
class System::BranchesOf final : public Branches {
 public:
  BranchesOf(System& system, std::size_t selector, NodeObserver* observer)
      : system_(system), selector_(selector), observer_(observer) {}

  std::size_t size() const override { return state().feeds_.size(); }

  const Outcome<>& evaluate(std::size_t branch) override {
    const NodeState& asked = producer(branch);
    for (const std::size_t i : system_.regions_.branch(selector_, branch)) {
      NodeState& node = system_.nodes_[i];
      if (node.evaluated_tick_ == system_.tick_) continue;
      node.evaluated_tick_ = system_.tick_;
      if (system_.expects_)
        system_.evaluate_specially(i, observer_);
      else
        system_.evaluate_node(i, observer_);
      if (observer_ != nullptr) observer_->end_node(i);
    }
    return asked.outcome;
  }

  const Output* output(std::size_t branch) const override {
    return producer(branch).has_value ? &producer(branch).output() : nullptr;
  }

 private:
  const NodeState& state() const { return system_.nodes_[selector_]; }
  const NodeState& producer(std::size_t branch) const {
    return *state().feeds_.at(branch).producer;
  }

  System& system_;
  std::size_t selector_;
  NodeObserver* observer_;
};

System::System(const Plan& plan, std::uint64_t seed, SystemOptions options)
    : plan_(&plan),
      folding_(options.folding),
      follow_data_(options.follow_data),
      post_dominators_(plan),
      nodes_(plan.nodes.size()),
      regions_([&] {
        std::vector<bool> given(plan.nodes.size());
        for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
          StandIn made = make_module(i, plan.nodes[i], options.stand_ins, nodes_[i].is_own_type_);
          nodes_[i].module = std::move(made.module);
          given[i] = nodes_[i].is_given_ = made.is_given;
          nodes_[i].seed_ = derive_seed(seed, plan.nodes[i].name);
        }
        return Regions(plan, given);
      }()) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) connect(i);
}

System::~System() {
  if (!is_open_) return;
  for (NodeState& node : nodes_)
    (void)guarded([&]() -> Outcome<> { return node.module->close(), Outcome<>(); });
}

void System::connect(std::size_t i) {
  const PlanNode& node = plan_->nodes[i];
  NodeState& state = nodes_[i];
  state.own_.estimate = Estimate(*node.interface.output, node.frame);
  const bool has_parts = node.interface.output->samples || !node.interface.output->element.empty();
  if (node.type->checked && state.is_own_type_)
    state.check_ = has_parts ? NodeState::Check::parts : NodeState::Check::nothing;
  if (!state.is_given_) connect_inputs(i);
  state.evaluation_.emplace(
      Evaluation{.owner = static_cast<std::uint32_t>(i),
                 .parameters = node.parameters,
                 .inputs = state.inputs_,
                 .correlation_unknown = node.correlation_unknown && !state.is_given_,
                 .run_seed = state.seed_});
  state.is_plain_ = !state.selects_ && !state.reads_selectors_ &&
                    !state.evaluation_->correlation_unknown &&
                    node.interface.output->element.empty();
}

void System::connect_inputs(std::size_t i) {
  const PlanNode& node = plan_->nodes[i];
  NodeState& state = nodes_[i];
  state.selects_ = node.type->selects;
  for (const PlanInput& input : node.inputs) {
    const NodeState& producer = nodes_[input.node];
    state.feeds_.push_back({&producer, input.max_age.value_or(Duration::max())});
    state.inputs_.push_back(&producer.output());
    state.reads_selectors_ |= producer.selects_;
  }
}

std::vector<OpenFault> System::open() {
  std::vector<OpenFault> faults;
  if (is_open_) return faults;
  is_open_ = true;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!regions_.is_needed(i)) continue;
    Outcome<> outcome = guarded([&] { return nodes_[i].module->open(); });
    if (outcome.is_fault()) {
      faults.push_back({i, outcome.fault()});
      nodes_[i].module = broken(plan_->nodes[i], outcome.fault());
    } else if (follow_data_ && nodes_[i].feeds_.empty()) {
      (void)guarded([&]() -> Outcome<> {
        nodes_[i].has_data_clock_ = nodes_[i].module->next_time().has_value();
        nodes_[i].is_plain_ &= !nodes_[i].has_data_clock_;
        return {};
      });
    }
  }
  return faults;
}

void System::begin_tick(Time time) {
  if (!is_open_) [[unlikely]]
    open();
  start_tick(time);
}

void System::start_tick(Time time) {
  time_ = time;
  tick_seed_ = mix(static_cast<std::uint64_t>(tick_));
  ++tick_;
  expects_ = false;
}

[[gnu::always_inline]] inline const Evaluation& System::evaluation(std::size_t i) {
  NodeState& state = nodes_[i];
  Evaluation& evaluation = *state.evaluation_;
  evaluation.tick = tick_ - 1;
  evaluation.time = time_;
  evaluation.seed = mix(state.seed_ ^ tick_seed_);
  return evaluation;
}

void System::evaluate(Time time) {
  begin_tick(time);
  for (const std::size_t i : regions_.always()) evaluate_node(i);
}

/// Whether the node has all that it needs for this tick; then `acquired` is its inputs' range.
/// Otherwise its outcome is set. In one pass and free of what seldom happens, since this is what a
/// tick mostly does.
[[gnu::always_inline]] inline bool System::take_inputs(std::size_t i, bool& correlation_unknown) {
  NodeState& state = nodes_[i];
  bool any_fresh = state.feeds_.empty();
  bool has_all_values = true;
  bool any_fault = false;
  bool any_stale = false;
  Acquisition acquired{time_, state.feeds_.empty() ? time_ : Time::min()};
  const Output* const* next_input = state.inputs_.data();
  for (const NodeState::Feed& feed : state.feeds_) {
    const NodeState& producer = *feed.producer;
    const Output& output = **next_input++;
    const Acquisition& input = output.acquired;
    any_fault |= producer.outcome.is_fault();
    any_fresh |= producer.fresh;
    has_all_values &= producer.has_value;
    any_stale |= age_of(input.oldest, time_) > feed.max_age;
    correlation_unknown |= output.estimate.correlation_unknown;
    acquired.include(input);
  }
  if (!any_fault && any_fresh && has_all_values && !any_stale) {
    state.own_.acquired = acquired;
    return true;
  }
  if (any_fault)
    inherit_fault(i);
  else if (!any_fresh || !has_all_values)
    state.outcome = Pending{};
  else
    report_stale(i);
  return false;
}

void System::inherit_fault(std::size_t i) {
  NodeState& state = nodes_[i];
  for (const PlanInput& input : plan_->nodes[i].inputs) {
    const NodeState& producer = nodes_[input.node];
    if (!producer.outcome.is_fault()) continue;
    state.origin = producer.origin.value_or(input.node);
    state.outcome = producer.outcome.fault();
    break;
  }
  state.has_value = false;
}

void System::report_stale(std::size_t i) {
  NodeState& state = nodes_[i];
  for (const PlanInput& input : plan_->nodes[i].inputs) {
    const Duration age = age_of(nodes_[input.node].output().acquired.oldest, time_);
    if (!input.max_age || age <= *input.max_age) continue;
    state.outcome =
        Fault{FaultKind::stale,
              fmt::format("'{}' is {:.4g} s old; at most {:.4g} s are allowed",
                          plan_->nodes[input.node].name, seconds(age), seconds(*input.max_age))};
    break;
  }
  state.origin = i;
  state.has_value = false;
}

/// Whether what a module gave is as its payload declares; what is checked where it is made need not
/// be looked at again.
[[gnu::always_inline]] inline bool System::keeps_contract(std::size_t i) const {
  return nodes_[i].check_ == NodeState::Check::nothing || passes_check(i);
}

bool System::passes_check(std::size_t i) const {
  const NodeState& state = nodes_[i];
  const PayloadDescriptor& payload = *plan_->nodes[i].interface.output;
  return (state.check_ == NodeState::Check::all
              ? find_breach(state.own_, payload)
              : find_breach_in_parts(state.own_, payload)) == Breach::none;
}

void System::reject_output(std::size_t i) {
  NodeState& state = nodes_[i];
  state.outcome = describe_breach(state.own_, *plan_->nodes[i].interface.output);
  state.origin = i;
  state.has_value = false;
}

template <typename Call>
[[gnu::always_inline]] inline void System::call_module(std::size_t i, Call call) {
  NodeState& state = nodes_[i];
  try {
    state.outcome = call();
  } catch (const std::exception& error) {
    state.outcome = Fault{FaultKind::internal, fmt::format("the module threw: {}", error.what())};
  } catch (...) {
    state.outcome = Fault{FaultKind::internal, "the module threw"};
  }
  if (state.outcome.has_output()) {
    const Estimate& estimate = state.own_.estimate;
    if (!keeps_contract(i)) return reject_output(i);
    state.fresh = true;
    state.has_value = true;
    if (estimate.lineage.size() > estimate.dimension() && worth_folding(i)) fold(i);
  } else if (state.outcome.is_fault()) {
    state.origin = i;
    state.has_value = false;
  }
}

template <typename Call>
Outcome<> System::carry(std::size_t i, Call call) {
  const Evaluation& e = evaluation(i);
  return carry_correlation(*plan_->nodes[i].type, e, nodes_[i].own_, [&] { return call(e); });
}

void System::evaluate_node(std::size_t i, NodeObserver* observer) {
  NodeState& state = nodes_[i];
  state.fresh = false;
  state.origin.reset();
  if (!state.is_plain_) [[unlikely]]
    return evaluate_specially(i, observer);
  const Acquisition held = state.own_.acquired;
  bool correlation_unknown = state.own_.estimate.correlation_unknown;
  if (!take_inputs(i, correlation_unknown)) return;
  call_module(i, [&] {
    if (correlation_unknown) [[unlikely]]
      return carry(i, [&](const Evaluation& e) { return state.module->evaluate(e, state.own_); });
    return state.module->evaluate(evaluation(i), state.own_);
  });
  if (state.outcome.is_pending()) state.own_.acquired = held;
}

/// Nodes that do more than take inputs and evaluate, and all of them in a prediction.
void System::evaluate_specially(std::size_t i, NodeObserver* observer) {
  NodeState& state = nodes_[i];
  state.fresh = false;
  state.origin.reset();
  if (state.selects_) return select(i, observer);
  const Acquisition held = state.own_.acquired;
  if (state.reads_selectors_) find_inputs(i);
  bool correlation_unknown = false;
  if (!take_inputs(i, correlation_unknown)) return;
  if (state.has_data_clock_ && !expects_ && awaits_data(i)) {
    state.outcome = Pending{};
  } else {
    call_module(i, [&] {
      return carry(i, [&](const Evaluation& e) {
        return expects_ ? state.module->expect(e, nullptr, state.own_)
                        : state.module->evaluate(e, state.own_);
      });
    });
  }
  if (state.outcome.is_pending()) state.own_.acquired = held;
}

/// Where the outputs of selectors are, now.
void System::find_inputs(std::size_t i) {
  NodeState& state = nodes_[i];
  for (std::size_t k = 0; k < state.feeds_.size(); ++k)
    state.inputs_[k] = &state.feeds_[k].producer->output();
}

/// Whether the source's next data are of a later time than this tick's.
bool System::awaits_data(std::size_t i) {
  std::optional<Time> next;
  (void)guarded([&]() -> Outcome<> { return next = nodes_[i].module->next_time(), Outcome<>(); });
  return next && *next > time_;
}

std::optional<Time> System::next_data_time() {
  std::optional<Time> earliest;
  if (!is_open_) open();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (!nodes_[i].has_data_clock_) continue;
    (void)guarded([&]() -> Outcome<> {
      const std::optional<Time> next = nodes_[i].module->next_time();
      // What no selector asked for when it was its turn would be next for ever.
      if (!regions_.is_always(i) && tick_ > 0 && next && *next <= time_) return {};
      if (next && (!earliest || *next < *earliest)) earliest = next;
      return {};
    });
  }
  return earliest;
}

/// Lets a selector have its branches evaluated as it asks, and passes on what it selects.
void System::select(std::size_t i, NodeObserver* observer) {
  NodeState& state = nodes_[i];
  for (const std::size_t k : regions_.on_demand(i)) {
    nodes_[k].fresh = false;
    nodes_[k].outcome = Pending{};
  }
  find_inputs(i);
  BranchesOf branches(*this, i, observer);
  std::optional<std::size_t> chosen;
  state.outcome = guarded([&]() -> Outcome<> {
    Outcome<std::size_t> selected =
        static_cast<Selector&>(*state.module).select(evaluation(i), branches);
    if (selected.is_pending()) return Pending{};
    if (selected.is_fault()) return selected.fault();
    chosen = *selected;
    if (*chosen < state.feeds_.size()) return {};
    return Fault{FaultKind::internal,
                 fmt::format("it selected branch {} of {}", *chosen + 1, state.feeds_.size())};
  });
  if (state.outcome.is_fault()) {
    state.origin = i;
    state.has_value = false;
    return;
  }
  if (!chosen) {
    // What it holds is its branch's own, which has another value by now where it was evaluated.
    const NodeState& held = *state.feeds_[state.selected].producer;
    state.has_value = state.has_value && held.has_value && !held.fresh;
    return;
  }
  state.selected = *chosen;
  const NodeState& branch = *state.feeds_[*chosen].producer;
  state.current_ = branch.current_;
  state.outcome = branch.outcome.is_fault()     ? Outcome<>(branch.outcome.fault())
                  : branch.outcome.has_output() ? Outcome<>()
                                                : Outcome<>(Pending{});
  state.fresh = branch.fresh;
  state.has_value = branch.has_value;
  if (branch.outcome.is_fault())
    state.origin = branch.origin.value_or(plan_->nodes[i].inputs[*chosen].node);
}

/// Whether `fold` would find anything: more columns than components, of one owner or in all.
bool System::worth_folding(std::size_t i) const {
  const Lineage& lineage = nodes_[i].own_.estimate.lineage;
  const std::size_t dimension = lineage.dimension();
  if (folding_ == Folding::none) return false;
  std::size_t count = 0;
  std::uint32_t owner = lineage.sources().front().owner;
  for (const Source& source : lineage.sources()) {
    if (folding_ == Folding::per_owner && source.owner != owner) count = 0;
    owner = source.owner;
    if (foldable(i, source) && ++count > dimension) return true;
  }
  return false;
}

void System::fold(std::size_t i) {
  Lineage& lineage = nodes_[i].own_.estimate.lineage;
  const auto may_fold = [this, i](const Source& source) { return foldable(i, source); };
  const auto folder = static_cast<std::uint32_t>(i);
  if (folding_ == Folding::per_owner)
    lineage.fold(may_fold, folder);
  else
    lineage.fold_together(may_fold, folder, folder);
}

void System::expect() {
  start_tick(time_);
  expects_ = true;
  for (const std::size_t i : regions_.always()) evaluate_specially(i, nullptr);
}

Outcome<> System::command(std::size_t node, const Command& command) {
  return guarded([&] { return nodes_.at(node).module->command(command); });
}

std::string System::note(std::size_t node) const {
  try {
    return nodes_.at(node).module->note();
  } catch (const std::exception& error) {
    return std::string("the module threw: ") + error.what();
  } catch (...) {
    return "the module threw";
  }
}

std::vector<TestReport> System::run_tests(std::size_t node) {
  try {
    (void)evaluation(node);
    Evaluation now = *nodes_.at(node).evaluation_;
    now.tick = std::max<std::int64_t>(now.tick, 0);  // before the first: as in it
    return nodes_.at(node).module->run_tests(now);
  } catch (const std::exception& error) {
    return {{"embedded tests", false, fmt::format("the module threw: {}", error.what())}};
  } catch (...) {
    return {{"embedded tests", false, "the module threw"}};
  }
}

}  // namespace ilss
