#include "framework/study/set_comparison.h"

#include <algorithm>
#include <cmath>

#include "framework/graph/system.h"
#include "framework/runtime/cycle_clock.h"

namespace ilss {
namespace {

/// An element that was found, against the true one.
struct MatchedElement {
  std::int64_t tick;
  std::size_t truth;  ///< which of the tick's elements of its payload
  Eigen::VectorXd error;
  NormalizedError normalized;
  double distance;  ///< of places (m)

  bool has_same_truth_as(const MatchedElement& other) const {
    return tick == other.tick && truth == other.truth;
  }
};

/// Elements of one tick's set; nothing where the system has no output.
using TickElements = std::optional<Elements>;

/// Measures the modules of a tick but for simulated sensors, whose time is no device's.
class WorkTimer final : public NodeObserver {
 public:
  explicit WorkTimer(const Plan& plan) : plan_(plan) {}
  void begin_tick() {
    sum_ = 0;
    last_ = clock_.now();
  }
  void end_node(std::size_t node) override {
    const std::uint64_t now = clock_.now();
    if (!plan_.nodes[node].interface.draws_readings) sum_ += clock_.nanoseconds(last_, now);
    last_ = now;
  }
  void end_tick() {}
  std::uint64_t nanoseconds() const { return sum_; }

 private:
  const Plan& plan_;
  const CycleClock& clock_ = CycleClock::instance();
  std::uint64_t last_ = 0;
  std::uint64_t sum_ = 0;
};

void count_fault(const Fault& fault, std::map<FaultKind, FaultCount>& faults) {
  FaultCount& of_kind = faults[fault.kind];
  if (of_kind.count++ == 0) of_kind.message = fault.message;
}

/// Runs the truth, or what is tolerated, over all ticks.
std::vector<TickElements> run_reference(const Plan& plan, const Study& study,
                                        std::map<FaultKind, FaultCount>& faults) {
  System system(plan, study.seed);
  std::vector<TickElements> ticks;
  for (std::int64_t r = 0; r < study.runs; ++r) {
    system.evaluate(time_at(static_cast<double>(r)));
    const NodeState& state = system.node(plan.outputs.front());
    TickElements& elements = ticks.emplace_back();
    if (state.outcome.has_output())
      elements = state.output().elements;
    else if (state.outcome.is_fault())
      count_fault(state.outcome.fault(), faults);
  }
  return ticks;
}

std::vector<const Estimate*> elements_of(const ElementRule& rule,
                                         std::span<const Estimate> elements) {
  std::vector<const Estimate*> relevant;
  for (const Estimate& element : elements)
    if (rule.applies_to(element)) relevant.push_back(&element);
  return relevant;
}

MatchedElement judge_match(const ElementRule& rule, const Estimate& truth, const Estimate& found) {
  const Eigen::VectorXd error = difference(found, truth.value);
  const Eigen::MatrixXd covariance = independent_covariance(found, truth);
  MatchedElement match{};
  match.error = error(rule.judged);
  match.normalized = normalized_squared_error(match.error, covariance(rule.judged, rule.judged));
  match.distance = error(rule.place).norm();
  return match;
}

/// Scores one payload's elements over the ticks of a case.
class ElementScorer {
 public:
  explicit ElementScorer(const ElementRule& rule) : rule_(rule) {}

  void add(std::int64_t tick, std::span<const Estimate> truth, std::span<const Estimate> tolerated,
           std::span<const Estimate> found) {
    const auto true_elements = elements_of(rule_, truth);
    auto found_elements = elements_of(rule_, found);
    score_.truth += static_cast<std::int64_t>(true_elements.size());
    score_.found += static_cast<std::int64_t>(found_elements.size());
    for (const auto& [t, f] : match_elements(rule_, true_elements, found_elements)) {
      MatchedElement& match =
          matches_.emplace_back(judge_match(rule_, *true_elements[t], *found_elements[f]));
      match.tick = tick;
      match.truth = t;
      found_elements[f] = nullptr;
    }
    std::erase(found_elements, nullptr);
    score_.tolerated += static_cast<std::int64_t>(
        match_elements(rule_, elements_of(rule_, tolerated), found_elements).size());
  }

  const std::vector<MatchedElement>& matches() const { return matches_; }

  ElementScore finish(std::optional<double> gate) const {
    ElementScore score = score_;
    score.matched = static_cast<std::int64_t>(matches_.size());
    for (const MatchedElement& match : matches_) {
      score.consistency.add(match.normalized);
      const int rank = match.normalized.rank;
      score.inside_95 += is_inside(match, rank > 0 ? chi_square_quantile(rank, 0.95) : 0);
      if (gate) score.inside_gate += is_inside(match, *gate);
    }
    if (matches_.empty()) return score;
    for (std::size_t c = 0; c < rule_.judged.size(); ++c) score.errors.push_back(errors_of(c));
    score.median_distance = median([](const MatchedElement& match) { return match.distance; });
    return score;
  }

 private:
  static bool is_inside(const MatchedElement& match, double limit) {
    // What the stated covariance says cannot be is outside, but for rounding.
    constexpr double rounding = 1e-6;
    return match.normalized.value <= limit && match.normalized.unexplained <= rounding;
  }

  template <typename Figure>
  double median(Figure figure) const {
    std::vector<double> figures;
    for (const MatchedElement& match : matches_) figures.push_back(figure(match));
    const auto middle = figures.begin() + static_cast<std::ptrdiff_t>(figures.size() / 2);
    std::nth_element(figures.begin(), middle, figures.end());
    if (figures.size() % 2 != 0) return *middle;
    return (*middle + *std::max_element(figures.begin(), middle)) / 2;
  }

  MatchedErrors errors_of(std::size_t component) const {
    const auto c = static_cast<Eigen::Index>(component);
    const auto n = static_cast<double>(matches_.size());
    MatchedErrors errors;
    for (const MatchedElement& match : matches_) errors.bias += match.error[c] / n;
    double squares = 0;
    for (const MatchedElement& match : matches_)
      squares += std::pow(match.error[c] - errors.bias, 2);
    errors.standard_deviation = matches_.size() > 1 ? std::sqrt(squares / (n - 1)) : 0;
    errors.median = median([c](const MatchedElement& match) { return std::abs(match.error[c]); });
    return errors;
  }

  const ElementRule& rule_;
  ElementScore score_;
  std::vector<MatchedElement> matches_;  ///< by tick and truth
};

/// The sd of an alternative's errors over the reference's, of the matches that both have.
std::vector<double> relative_deviations(const std::vector<MatchedElement>& matches,
                                        const std::vector<MatchedElement>& reference) {
  std::vector<std::pair<const MatchedElement*, const MatchedElement*>> common;
  auto other = reference.begin();
  for (const MatchedElement& match : matches) {
    while (other != reference.end() &&
           std::pair(other->tick, other->truth) < std::pair(match.tick, match.truth))
      ++other;
    if (other != reference.end() && other->has_same_truth_as(match))
      common.emplace_back(&match, &*other);
  }
  if (common.size() < 2) return {};
  const Eigen::Index components = common.front().first->error.size();
  Eigen::VectorXd means[2] = {Eigen::VectorXd::Zero(components), Eigen::VectorXd::Zero(components)};
  for (const auto& [a, b] : common) {
    means[0] += a->error / static_cast<double>(common.size());
    means[1] += b->error / static_cast<double>(common.size());
  }
  Eigen::VectorXd squares[2] = {Eigen::VectorXd::Zero(components),
                                Eigen::VectorXd::Zero(components)};
  for (const auto& [a, b] : common) {
    squares[0] += (a->error - means[0]).cwiseAbs2();
    squares[1] += (b->error - means[1]).cwiseAbs2();
  }
  std::vector<double> ratios;
  for (Eigen::Index c = 0; c < components; ++c)
    ratios.push_back(std::sqrt(squares[0][c] / squares[1][c]));
  return ratios;
}

/// One alternative over the ticks of a case.
struct AlternativeRun {
  SetAlternative result;
  std::vector<ElementScorer> scorers;
};

AlternativeRun run_alternative(const Plan& plan, const Study& study,
                               const std::vector<TickElements>& truth,
                               const std::vector<TickElements>& tolerated) {
  AlternativeRun run;
  for (const ElementRule& rule : study.judged) run.scorers.emplace_back(rule);
  System system(plan, study.seed);
  WorkTimer timer(plan);
  const std::size_t output = plan.outputs.front();
  for (std::int64_t r = 0; r < study.runs; ++r) {
    system.evaluate(time_at(static_cast<double>(r)), timer);
    run.result.time.record(timer.nanoseconds());
    const NodeState& state = system.node(output);
    std::span<const Estimate> found;
    if (state.outcome.has_output()) {
      ++run.result.outputs;
      found = state.output().elements;
    } else if (state.outcome.is_fault()) {
      count_fault(state.outcome.fault(), run.result.faults);
    } else {
      ++run.result.pending;
    }
    const auto tick = static_cast<std::size_t>(r);
    if (!truth[tick]) continue;
    std::span<const Estimate> tolerable;
    if (!tolerated.empty() && tolerated[tick]) tolerable = *tolerated[tick];
    for (ElementScorer& scorer : run.scorers) scorer.add(r, *truth[tick], tolerable, found);
  }
  for (const ElementScorer& scorer : run.scorers)
    run.result.scores.push_back(scorer.finish(study.validation_gate));
  return run;
}

SetCase compare_case(const Study& study, const StudyCase& one) {
  SetCase compared;
  compared.name = one.name;
  const auto truth = run_reference(std::get<Plan>(one.truth), study, compared.truth_faults);
  compared.ticks = std::count_if(truth.begin(), truth.end(),
                                 [](const TickElements& elements) { return elements.has_value(); });
  std::vector<TickElements> tolerated;
  if (one.tolerated) tolerated = run_reference(*one.tolerated, study, compared.truth_faults);
  std::vector<AlternativeRun> runs;
  for (const StudySource& alternative : one.alternatives)
    runs.push_back(run_alternative(std::get<Plan>(alternative), study, truth, tolerated));
  for (AlternativeRun& run : runs) {
    for (std::size_t e = 0; study.reference && e < run.scorers.size(); ++e)
      run.result.scores[e].relative_deviation = relative_deviations(
          run.scorers[e].matches(), runs[*study.reference].scorers[e].matches());
    compared.alternatives.push_back(run.result);
  }
  return compared;
}

}  // namespace

double ElementScore::mean_nees() const {
  return consistency.mean() * consistency.degrees_of_freedom() /
         static_cast<double>(consistency.count());
}

Interval ElementScore::nees_bounds(double probability) const {
  const Interval bounds = consistency.bounds(probability);
  const double scale = consistency.degrees_of_freedom() / static_cast<double>(consistency.count());
  return {bounds.low * scale, bounds.high * scale};
}

std::vector<SetCase> compare_sets(const Study& study) {
  std::vector<SetCase> cases;
  for (const StudyCase& one : study.cases) cases.push_back(compare_case(study, one));
  return cases;
}

}  // namespace ilss
