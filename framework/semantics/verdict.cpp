#include "framework/semantics/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "framework/estimate/consistency.h"
#include "framework/semantics/second_order.h"

namespace ilss {
namespace {

/// Of the trials: the same system always gets the same verdict.
constexpr std::uint64_t trial_seed = 0;
/// What counts for rounding, against the numbers that an output is made of.
constexpr double relative_rounding = 1e-12;

/// Whether the second order is small along a direction. `size` is of the numbers that make it up:
/// an error of their rounding is no error.
bool is_clear(const Moments& moments, double variance, double size) {
  const double bias = std::abs(moments.bias());
  const double extra = moments.second_order_variance();
  const double change = std::abs(moments.secant_variance - variance);
  const double rounding = relative_rounding * size;
  if (bias <= rounding && std::sqrt(extra) <= rounding && std::sqrt(change) <= rounding)
    return true;
  return bias <= clear_relative_bias * std::sqrt(variance) &&
         extra <= clear_relative_variance * variance &&
         change <= clear_relative_variance * variance;
}

/// The largest number of each unit among the nodes that an output follows from: rounding is
/// relative to it, not to what is left where large numbers cancel.
class Sizes {
 public:
  /// Takes them from the system as it stands, along all steps of a perturbation.
  void take(const System& system, const Perturbation& perturbation) {
    const std::span<const Perturbation::Step> steps = perturbation.steps();
    if (units_of_step_.empty())
      for (const Perturbation::Step& step : steps) find_units(system.plan().nodes[step.node]);
    sizes_.assign(steps.size() * units_.size(), 0.0);
    for (std::size_t s = 0; s < steps.size(); ++s) {
      double* const own = sizes_.data() + s * units_.size();
      if (!steps[s].is_there()) continue;
      for (const std::size_t producer : steps[s].feeds())
        for (std::size_t u = 0; u < units_.size(); ++u)
          own[u] = std::max(own[u], sizes_[producer * units_.size() + u]);
      std::size_t at = 0;
      for (const Estimate* estimate : {&system.node(steps[s].node).output().estimate,
                                       &system.plan().nodes[steps[s].node].parameters})
        for (std::size_t c = 0; c < estimate->dimension(); ++c) {
          double& size = own[units_of_step_[s][at++]];
          size = std::max(size, std::abs(estimate->value[c]));
        }
    }
  }
  /// Of the unit of a component of a step's output.
  double of(std::size_t step, std::size_t component) const {
    return sizes_[step * units_.size() + units_of_step_[step][component]];
  }

 private:
  void find_units(const PlanNode& node) {
    std::vector<std::size_t>& units = units_of_step_.emplace_back();
    for (const auto* components :
         {&node.interface.output->components, &node.parameters.type->components})
      for (const Component& component : *components)
        units.push_back(units_.emplace(component.unit, units_.size()).first->second);
  }

  std::map<std::string, std::size_t, std::less<>> units_;
  std::vector<std::vector<std::size_t>> units_of_step_;  ///< of the output, then the parameters
  std::vector<double> sizes_;                            ///< a row of units a step
};

/// How far the trials of a look may be from what first order states.
struct Tolerances {
  double coverage;   ///< of the share inside an interval or ellipsoid
  double mean;       ///< in standard deviations
  double deviation;  ///< relative
};
/// Three standard deviations of what as many trials scatter, if all is as stated.
constexpr Tolerances glance_tolerances{0.029, 0.135, 0.095};
constexpr Tolerances pilot_tolerances{pilot_tolerance, 0.5, 0.3};

/// What trials did to one output, held against what is stated of it.
class Look {
 public:
  void begin(std::size_t dimension) {
    components_.assign(dimension, {});
    trials_ = faults_ = inside_ = 0;
    fault_.clear();
  }
  /// The intervals whose share of trials is wanted: around the stated value, and around the
  /// corrected one.
  void set_limits(std::size_t c, double deviation, double bias, double corrected_deviation) {
    components_[c].limit = normal_coverage_factor_95 * deviation;
    components_[c].bias = bias;
    components_[c].corrected_limit = normal_coverage_factor_95 * corrected_deviation;
  }
  void add(std::span<const double> offset, bool inside_ellipsoid) {
    const double weight = 1 / static_cast<double>(++trials_);
    inside_ += inside_ellipsoid ? 1 : 0;
    for (std::size_t c = 0; c < components_.size(); ++c) {
      ComponentLook& look = components_[c];
      const double x = offset[c];
      look.within += std::abs(x) <= look.limit ? 1 : 0;
      look.within_corrected += std::abs(x - look.bias) <= look.corrected_limit ? 1 : 0;
      // Welford's update, which does not lose digits where the bias is large.
      const double from_mean = x - look.mean;
      look.mean += from_mean * weight;
      look.squares += from_mean * (x - look.mean);
    }
  }
  void add_fault(const Perturbation& perturbation, std::size_t target) {
    if (faults_++ == 0) fault_ = perturbation.fault(target).message;
  }

  std::size_t trials() const { return trials_; }  ///< that gave an output
  std::size_t faults() const { return faults_; }
  const std::string& fault() const { return fault_; }  ///< of the first that gave none
  double mean(std::size_t c) const { return components_[c].mean; }
  double deviation(std::size_t c) const {
    return std::sqrt(components_[c].squares / std::max(1.0, static_cast<double>(trials_) - 1));
  }
  double coverage(std::size_t c) const { return share(components_[c].within); }
  double corrected_coverage(std::size_t c) const { return share(components_[c].within_corrected); }
  double joint_coverage() const { return share(inside_); }

 private:
  struct ComponentLook {
    double limit = 0;
    double bias = 0;
    double corrected_limit = 0;
    std::size_t within = 0;
    std::size_t within_corrected = 0;
    double mean = 0;
    double squares = 0;  ///< summed, of distances from the mean
  };

  double share(std::size_t count) const {
    return static_cast<double>(count) / static_cast<double>(trials_);
  }

  std::vector<ComponentLook> components_;
  std::size_t trials_ = 0;
  std::size_t faults_ = 0;
  std::size_t inside_ = 0;
  std::string fault_;
};

/// Judges one output by its second order and by trials.
class Judgement {
 public:
  /// Takes what the second order showed. All must stay while it is used.
  void begin(const SecondOrder& second_order, const Estimate& estimate, const Sizes& sizes,
             std::size_t step, VerdictReport& report) {
    second_order_ = &second_order;
    estimate_ = &estimate;
    report_ = &report;
    clear_ = true;
    clear_component_.clear();
    negligible_.clear();
    rounding_.clear();
    for (std::size_t r = 0; r < second_order.moments.size(); ++r)
      if (r < estimate.dimension())
        take_component(r, sizes.of(step, r));
      else
        clear_ &= is_clear(second_order.moments[r], 1.0, 0.0);
    squared_radius_ = second_order.axes.rank() > 0 ? second_order.axes.squared_radius_95() : 0.0;
  }

  void begin_look() {
    look_.begin(estimate_->dimension());
    for (std::size_t c = 0; c < estimate_->dimension(); ++c)
      look_.set_limits(c, stated(c), report_->bias[c], corrected(c));
  }
  /// Takes a trial as the perturbation stands.
  void take_trial(const Perturbation& perturbation, std::size_t target) {
    if (perturbation.failed(target)) return look_.add_fault(perturbation, target);
    offset_.resize(estimate_->dimension());
    perturbation.offset(target, offset_);
    look_.add(offset_, second_order_->axes.squared_distance(offset_) <= squared_radius_);
  }

  /// Whether more than the glance just taken is needed.
  bool doubtful() const {
    if (!clear_ || second_order_->meets_fault || look_.faults() > 0) return true;
    for (std::size_t c = 0; c < estimate_->dimension(); ++c)
      if (!negligible_[c] && !holds(c, glance_tolerances)) return true;
    return !joint_coverage_holds(glance_tolerances.coverage);
  }

  /// Decides by the many trials just taken.
  void take_pilot() {
    report_->piloted = true;
    const auto trials = static_cast<double>(look_.trials() + look_.faults());
    const double fault_share = static_cast<double>(look_.faults()) / trials;
    if (look_.trials() == 0 || fault_share > largest_fault_share) {
      report_->verdict = Verdict::invalid;
      report_->reason = fmt::format("{:.2g} % of all errors leave no answer: {}", 100 * fault_share,
                                    look_.fault());
      return;
    }
    for (std::size_t c = 0; c < estimate_->dimension(); ++c) {
      report_->components[c] = judge_component(c);
      report_->verdict = std::max(report_->verdict, report_->components[c]);
      if (report_->components[c] == Verdict::monte_carlo_required && clear_component_[c])
        report_->reason = "the error is not a normal one, though its second order is small";
    }
    if (report_->verdict != Verdict::linear_ok || joint_coverage_holds(pilot_tolerance)) return;
    report_->verdict = Verdict::second_order;
    report_->reason = second_order_->changes_label
                          ? "another case is near, and the components' errors together are not as "
                            "their covariance says"
                          : "the components' errors together are not as their covariance says";
  }

  /// An output without sources of error that no move or trial changes, such as a count, leaves
  /// nothing to correct.
  void finish() {
    if (report_->verdict != Verdict::linear_ok || !estimate_->lineage.empty() || !still()) return;
    report_->components.clear();
    report_->bias.clear();
    report_->extra_variance.clear();
  }

 private:
  void take_component(std::size_t c, double size) {
    const Moments& moments = second_order_->moments[c];
    const double variance = estimate_->lineage.variance(c);
    const bool negligible = is_negligible(moments, c, variance);
    const bool clear = negligible || is_clear(moments, variance, size);
    clear_ &= clear;
    clear_component_.push_back(clear ? 1 : 0);
    negligible_.push_back(negligible ? 1 : 0);
    rounding_.push_back(relative_rounding * size);
    report_->components.push_back(Verdict::linear_ok);
    report_->bias.push_back(moments.bias());
    report_->extra_variance.push_back(moments.second_order_variance() + moments.secant_variance -
                                      variance);
  }

  static bool near(double coverage, double tolerance) {
    return std::abs(coverage - 0.95) <= tolerance;
  }

  double stated(std::size_t c) const { return estimate_->lineage.standard_deviation(c); }
  /// The standard deviation with what the second order adds; 0 where nothing is left.
  double corrected(std::size_t c) const {
    return std::sqrt(std::max(0.0, estimate_->lineage.variance(c) + report_->extra_variance[c]));
  }

  /// Whether a component's trials are as first order states.
  bool holds(std::size_t c, const Tolerances& tolerances) const {
    const double deviation = stated(c);
    const double drawn = look_.deviation(c);
    const double bias = look_.mean(c);
    if (std::max({drawn, deviation, std::abs(bias)}) <= rounding_[c]) return true;
    return deviation > 0 && near(look_.coverage(c), tolerances.coverage) &&
           std::abs(bias) <= tolerances.mean * deviation &&
           std::abs(drawn - deviation) <= tolerances.deviation * deviation;
  }

  /// Whether the ellipsoid holds what it should; one that is thin by rounding says nothing.
  bool joint_coverage_holds(double tolerance) const {
    if (second_order_->axes.rank() == 0) return true;
    for (std::size_t c = 0; c < estimate_->dimension(); ++c)
      if (stated(c) > 0 && stated(c) <= rounding_[c]) return true;
    return near(look_.joint_coverage(), tolerance);
  }

  /// Pure numbers have no unit that would make them comparable.
  bool is_negligible(const Moments& moments, std::size_t component, double variance) const {
    const std::string& unit = estimate_->type->components[component].unit;
    if (unit == "1") return false;
    double largest = 0;
    for (std::size_t c = 0; c < estimate_->dimension(); ++c)
      if (estimate_->type->components[c].unit == unit)
        largest = std::max(largest, estimate_->lineage.variance(c));
    const double bias = moments.bias();
    return std::max(variance, moments.secant_variance) + moments.second_order_variance() +
               bias * bias <=
           negligible_error * negligible_error * largest;
  }

  Verdict judge_component(std::size_t c) const {
    const double variance = estimate_->lineage.variance(c);
    const double second_order = second_order_->moments[c].second_order_variance();
    if (negligible_[c]) return Verdict::linear_ok;
    if (!clear_component_[c] && second_order > variance) return Verdict::monte_carlo_required;
    if (holds(c, pilot_tolerances)) return Verdict::linear_ok;
    if (variance <= 0 || corrected(c) <= 0) return Verdict::monte_carlo_required;
    const bool as_corrected =
        near(look_.corrected_coverage(c), 2 * pilot_tolerance) &&
        std::abs(look_.deviation(c) - corrected(c)) <= pilot_tolerances.deviation * corrected(c);
    return as_corrected ? Verdict::second_order : Verdict::monte_carlo_required;
  }

  /// Whether no component's second order says anything.
  bool still() const {
    for (std::size_t c = 0; c < estimate_->dimension(); ++c)
      if (report_->bias[c] != 0 || report_->extra_variance[c] != 0) return false;
    return true;
  }

  const SecondOrder* second_order_ = nullptr;
  const Estimate* estimate_ = nullptr;
  VerdictReport* report_ = nullptr;
  Look look_;
  double squared_radius_ = 0;
  bool clear_ = true;  ///< of all directions
  std::vector<char> clear_component_;
  std::vector<char> negligible_;
  std::vector<double> rounding_;  ///< the largest spread that is but rounding, of a component
  std::vector<double> offset_;
};

/// Forgets a report, but not its buffers.
void reset(VerdictReport& report, Verdict verdict) {
  report.verdict = verdict;
  report.reason.clear();
  report.components.clear();
  report.bias.clear();
  report.extra_variance.clear();
  report.piloted = false;
}

/// Which of the nodes are judged together: those that share a function. What is only moved, such as
/// a sensor that several branches share, costs little more to move in each of them.
std::vector<std::vector<std::size_t>> groups_of(const System& system,
                                                const std::vector<std::size_t>& nodes,
                                                const std::vector<std::size_t>& cut) {
  const Plan& plan = system.plan();
  std::vector<std::optional<std::size_t>> finder(plan.nodes.size());  // who came there first
  std::vector<std::size_t> leader(nodes.size());
  const auto leader_of = [&](std::size_t i) {
    while (leader[i] != i) i = leader[i] = leader[leader[i]];
    return i;
  };
  const auto is_redone = [&](std::size_t node) {
    return plan.nodes[node].type->kind == ModuleKind::function && !system.is_given(node) &&
           !std::binary_search(cut.begin(), cut.end(), node);
  };
  std::vector<std::size_t> waiting;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    leader[i] = i;
    waiting = {nodes[i]};
    while (!waiting.empty()) {
      const std::size_t node = waiting.back();
      waiting.pop_back();
      if (!is_redone(node)) continue;
      if (finder[node]) {
        leader[leader_of(i)] = leader_of(*finder[node]);
        continue;
      }
      finder[node] = i;
      for (const PlanInput& input : plan.nodes[node].inputs) waiting.push_back(input.node);
    }
  }
  std::vector<std::vector<std::size_t>> members(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) members[leader_of(i)].push_back(i);
  std::erase_if(members, [](const auto& group) { return group.empty(); });
  return members;
}

}  // namespace

std::string_view verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::linear_ok:
      return "linear_ok";
    case Verdict::second_order:
      return "second_order";
    case Verdict::monte_carlo_required:
      return "monte_carlo_required";
    case Verdict::invalid:
      return "invalid";
  }
  return "invalid";
}

/// What the groups use one after another.
struct Judge::Tools {
  ErrorDraws draws;
  SecondOrderSearch search = {};
  std::vector<double> errors = {};
};

/// Nodes that are judged together.
class Judge::Group {
 public:
  Group(std::vector<std::size_t> nodes, std::vector<std::size_t> places)
      : nodes_(std::move(nodes)),
        places_(std::move(places)),
        second_orders_(nodes_.size()),
        judgements_(nodes_.size()) {}

  void judge(const System& system, const std::vector<std::size_t>& cut, Tools& tools,
             std::vector<VerdictReport>& reports) {
    for (std::size_t t = 0; t < nodes_.size(); ++t) {
      const bool there = system.node(nodes_[t]).outcome.has_output();
      reset(reports[places_[t]], there ? Verdict::linear_ok : Verdict::invalid);
      second_orders_[t].wanted = there && !system.plan().nodes[nodes_[t]].type->states_no_error;
    }
    if (!any_wanted()) return;
    if (perturbation_)
      perturbation_->refresh();
    else
      perturbation_.emplace(system, nodes_, cut, Redo::functions);
    for (std::size_t t = 0; t < nodes_.size(); ++t)
      second_orders_[t].wanted &= perturbation_->movable(t) || !stated(system, t).lineage.empty();
    if (!any_wanted()) return;
    tools.search.run(system, *perturbation_, tools.draws, second_orders_);
    sizes_.take(system, *perturbation_);
    for (std::size_t t = 0; t < nodes_.size(); ++t)
      if (second_orders_[t].wanted)
        judgements_[t].begin(second_orders_[t], stated(system, t), sizes_,
                             perturbation_->step_of(t), reports[places_[t]]);
    sample(tools);
  }

 private:
  bool any_wanted() const {
    return std::any_of(second_orders_.begin(), second_orders_.end(),
                       [](const SecondOrder& output) { return output.wanted; });
  }
  const Estimate& stated(const System& system, std::size_t target) const {
    return system.node(nodes_[target]).output().estimate;
  }

  /// A glance at all, a pilot for those in doubt.
  void sample(Tools& tools) {
    looked_at_.clear();
    for (std::size_t t = 0; t < nodes_.size(); ++t)
      if (second_orders_[t].wanted) looked_at_.push_back(t);
    draw(tools, glance_trials);
    std::erase_if(looked_at_, [&](std::size_t t) { return !judgements_[t].doubtful(); });
    if (!looked_at_.empty()) draw(tools, pilot_trials);
    for (const std::size_t t : looked_at_) judgements_[t].take_pilot();
    for (std::size_t t = 0; t < nodes_.size(); ++t)
      if (second_orders_[t].wanted) judgements_[t].finish();
  }

  void draw(Tools& tools, std::size_t trials) {
    for (const std::size_t t : looked_at_) judgements_[t].begin_look();
    const std::size_t count = perturbation_->sources().size();
    for (std::size_t trial = 0; trial < trials; ++trial) {
      const std::size_t row = trial % ErrorDraws::block;
      if (row == 0)
        tools.draws.fill(perturbation_->sources(), trial / ErrorDraws::block, tools.errors);
      perturbation_->apply(std::span(tools.errors).subspan(row * count, count));
      for (const std::size_t t : looked_at_) judgements_[t].take_trial(*perturbation_, t);
    }
  }

  std::vector<std::size_t> nodes_;
  std::vector<std::size_t> places_;  ///< of their reports
  std::optional<Perturbation> perturbation_;
  std::vector<SecondOrder> second_orders_;
  std::vector<Judgement> judgements_;
  Sizes sizes_;
  std::vector<std::size_t> looked_at_;
};

Judge::Judge(const System& system, std::vector<std::size_t> nodes, std::vector<std::size_t> cut)
    : system_(&system), cut_(std::move(cut)), reports_(nodes.size()) {
  std::sort(cut_.begin(), cut_.end());
  for (std::vector<std::size_t>& places : groups_of(system, nodes, cut_)) {
    std::vector<std::size_t> members;
    members.reserve(places.size());
    for (const std::size_t place : places) members.push_back(nodes[place]);
    groups_.emplace_back(std::move(members), std::move(places));
  }
}

Judge::~Judge() = default;
Judge::Judge(Judge&&) noexcept = default;

const std::vector<VerdictReport>& Judge::judge() {
  if (!tools_)
    tools_ = std::make_unique<Tools>(Tools{{system_->plan().owners, trial_seed}, {}, {}});
  for (Group& group : groups_) group.judge(*system_, cut_, *tools_, reports_);
  return reports_;
}

std::vector<VerdictReport> judge(const System& system, const std::vector<std::size_t>& cut) {
  return Judge(system, system.plan().outputs, cut).judge();
}

}  // namespace ilss
