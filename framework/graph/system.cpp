#include "framework/graph/system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "framework/graph/guarded.h"

namespace ilss {
namespace {

/// Stands for a module whose constructor threw.
class BrokenModule final : public Module {
 public:
  explicit BrokenModule(std::string reason) : reason_(std::move(reason)) {}
  Outcome<> evaluate(const Evaluation&, Output&) override {
    return Fault{FaultKind::internal, reason_};
  }
  Outcome<> command(const Command&) override { return Fault{FaultKind::internal, reason_}; }

 private:
  std::string reason_;
};

std::unique_ptr<Module> create_module(const PlanNode& node) {
  try {
    return node.type->create(node.settings);
  } catch (const std::exception& error) {
    return std::make_unique<BrokenModule>(fmt::format("cannot be created: {}", error.what()));
  } catch (...) {
    return std::make_unique<BrokenModule>("cannot be created");
  }
}

/// Whether a sensor or estimator kept its contract: as many numbers as its payload says, and finite
/// ones with finite errors. Closed formulas are checked where they are made.
[[gnu::noinline]] bool keeps_contract(const Estimate& estimate, std::size_t dimension,
                                      std::size_t labels) {
  if (estimate.value.size() != dimension || estimate.lineage.dimension() != dimension ||
      estimate.labels.size() != labels)
    return false;
  double zero = 0;  // NaN once anything is not finite
  for (const double value : estimate.value) zero += 0 * value;
  for (std::size_t k = 0; k < estimate.lineage.size(); ++k)
    for (const double sensitivity : estimate.lineage.column(k)) zero += 0 * sensitivity;
  return zero == 0;
}

}  // namespace

System::System(const Plan& plan, std::uint64_t seed, Folding folding)
    : plan_(&plan), folding_(folding), post_dominators_(plan), nodes_(plan.nodes.size()) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const PlanNode& node = plan.nodes[i];
    NodeState& state = nodes_[i];
    state.module = create_module(node);
    state.output.estimate = Estimate(*node.interface.output, node.frame);
    state.seed_ = derive_seed(seed, node.name);
    state.dimension_ = static_cast<std::uint32_t>(node.interface.output->dimension());
    state.label_count_ = static_cast<std::uint32_t>(node.interface.output->labels.size());
    state.is_checked_ = node.type->checked;
    state.correlation_unknown_ = node.correlation_unknown;
    for (const PlanInput& input : node.inputs) {
      const NodeState& producer = nodes_[input.node];
      state.feeds_.push_back({&producer, input.max_age.value_or(INFINITY)});
      state.inputs_.push_back(&producer.output);
    }
  }
}

void System::begin_tick(double time) {
  time_ = time;
  tick_seed_ = mix(static_cast<std::uint64_t>(tick_));
  ++tick_;
}

[[gnu::always_inline]] inline Evaluation System::evaluation(std::size_t i) const {
  const NodeState& state = nodes_[i];
  return {.tick = tick_ - 1,
          .time = time_,
          .seed = mix(state.seed_ ^ tick_seed_),
          .owner = static_cast<std::uint32_t>(i),
          .parameters = plan_->nodes[i].parameters,
          .inputs = state.inputs_,
          .correlation_unknown = state.correlation_unknown_,
          .run_seed = state.seed_};
}

void System::evaluate(double time) {
  begin_tick(time);
  for (std::size_t i = 0; i < nodes_.size(); ++i) evaluate_node(i);
}

/// Whether the node has all that it needs for this tick; then `output.acquired` is the oldest
/// input's. Otherwise its outcome is set. In one pass and free of what seldom happens, since this
/// is what a tick mostly does.
[[gnu::always_inline]] inline bool System::take_inputs(std::size_t i) {
  NodeState& state = nodes_[i];
  bool any_fresh = state.feeds_.empty();
  bool all_there = true;
  bool any_fault = false;
  bool any_stale = false;
  double oldest = time_;
  for (const NodeState::Feed& feed : state.feeds_) {
    const NodeState& producer = *feed.producer;
    any_fault |= producer.outcome.is_fault();
    any_fresh |= producer.fresh;
    all_there &= producer.has_value;
    any_stale |= time_ - producer.output.acquired > feed.max_age;
    oldest = std::min(oldest, producer.output.acquired);
  }
  if (!any_fault && any_fresh && all_there && !any_stale) {
    state.output.acquired = oldest;
    return true;
  }
  if (any_fault)
    inherit_fault(i);
  else if (!any_fresh || !all_there)
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
    const double age = time_ - nodes_[input.node].output.acquired;
    if (!input.max_age || age <= *input.max_age) continue;
    state.outcome =
        Fault{FaultKind::stale, fmt::format("'{}' is {:.4g} s old; at most {:.4g} s are allowed",
                                            plan_->nodes[input.node].name, age, *input.max_age)};
    break;
  }
  state.origin = i;
  state.has_value = false;
}

void System::reject_output(std::size_t i) {
  NodeState& state = nodes_[i];
  const Estimate& estimate = state.output.estimate;
  const bool complete = estimate.value.size() == state.dimension_ &&
                        estimate.lineage.dimension() == state.dimension_ &&
                        estimate.labels.size() == state.label_count_;
  state.outcome =
      complete ? Fault{FaultKind::not_finite, "a value or its error is not finite"}
               : Fault{FaultKind::internal, "the output has other components or labels than " +
                                                plan_->nodes[i].interface.output->name};
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
    const Estimate& estimate = state.output.estimate;
    if (!state.is_checked_ && !keeps_contract(estimate, state.dimension_, state.label_count_))
      return reject_output(i);
    state.fresh = true;
    state.has_value = true;
    if (estimate.lineage.size() > estimate.dimension() && worth_folding(i)) fold(i);
  } else if (state.outcome.is_fault()) {
    state.origin = i;
    state.has_value = false;
  }
}

void System::evaluate_node(std::size_t i) {
  NodeState& state = nodes_[i];
  state.fresh = false;
  state.origin.reset();
  const double held_since = state.output.acquired;
  if (!take_inputs(i)) return;
  call_module(i, [&] { return state.module->evaluate(evaluation(i), state.output); });
  if (state.outcome.is_pending()) state.output.acquired = held_since;
}

/// Whether `fold` would find anything: more columns than components, of one owner or in all.
bool System::worth_folding(std::size_t i) const {
  const Lineage& lineage = nodes_[i].output.estimate.lineage;
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
  Lineage& lineage = nodes_[i].output.estimate.lineage;
  const auto may_fold = [this, i](const Source& source) { return foldable(i, source); };
  const auto folder = static_cast<std::uint32_t>(i);
  if (folding_ == Folding::per_owner)
    lineage.fold(may_fold, folder);
  else
    lineage.fold_together(may_fold, folder, folder);
}

Outcome<> System::take_operating_point(std::size_t i, const OperatingPoint& point) {
  NodeState& state = nodes_[i];
  const Estimate& given = point.value.estimate;
  const bool complete = std::none_of(given.value.begin(), given.value.end(),
                                     [](double value) { return std::isnan(value); });
  if (!point.has_error || !complete) {
    Outcome<> outcome = state.module->expect(evaluation(i), &point.value, state.output);
    if (!point.has_error || !outcome) return outcome;
  }
  // What was given stands with its own error; what was not is as the module says.
  Estimate& estimate = state.output.estimate;
  if (complete) {
    const std::string frame = estimate.frame;
    state.output = point.value;
    estimate.frame = frame;
    state.output.acquired = time_;
    return {};
  }
  Lineage lineage(given.dimension());
  for (std::size_t k = 0; k < estimate.lineage.size(); ++k)
    for (std::size_t c = 0; c < given.dimension(); ++c)
      if (std::isnan(given.value[c]))
        lineage.add(estimate.lineage.sources()[k], c, estimate.lineage.column(k)[c]);
  for (std::size_t k = 0; k < given.lineage.size(); ++k)
    lineage.add(given.lineage.sources()[k], given.lineage.column(k));
  estimate.lineage = std::move(lineage);
  for (std::size_t c = 0; c < given.dimension(); ++c)
    if (!std::isnan(given.value[c])) estimate.value[c] = given.value[c];
  return {};
}

void System::expect(const std::map<std::size_t, OperatingPoint>& operating_points) {
  begin_tick(time_);
  std::vector<char> needed(nodes_.size(), 0);
  for (const std::size_t output : plan_->outputs) needed[output] = 1;
  for (std::size_t i = nodes_.size(); i-- > 0;)
    if (needed[i] && !operating_points.contains(i))
      for (const PlanInput& input : plan_->nodes[i].inputs) needed[input.node] = 1;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    NodeState& state = nodes_[i];
    state.fresh = false;
    state.origin.reset();
    state.outcome = Pending{};
    if (!needed[i]) continue;
    const auto point = operating_points.find(i);
    if (point != operating_points.end()) {
      state.output.acquired = time_;
      call_module(i, [&] { return take_operating_point(i, point->second); });
    } else if (take_inputs(i)) {
      call_module(i, [&] { return state.module->expect(evaluation(i), nullptr, state.output); });
    }
  }
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
    return nodes_.at(node).module->run_tests(evaluation(node));
  } catch (const std::exception& error) {
    return {{"embedded tests", false, fmt::format("the module threw: {}", error.what())}};
  } catch (...) {
    return {{"embedded tests", false, "the module threw"}};
  }
}

}  // namespace ilss
