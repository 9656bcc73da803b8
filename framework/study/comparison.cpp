#include "framework/study/comparison.h"

#include <algorithm>
#include <cmath>

#include "framework/runtime/cycle_clock.h"
#include "framework/study/systematic_errors.h"

namespace ilss {
namespace {

/// Collects outputs and their errors over the runs of a case.
class ErrorCollector {
 public:
  ErrorCollector(const Study& study, const Estimate* truth, CaseMeasurement& measurement)
      : study_(study),
        truth_(truth),
        measurement_(measurement),
        value_(Eigen::VectorXd::Zero(dimension())),
        sum_(value_),
        squares_(value_),
        covered_(value_) {}

  void add_fault(const Fault& fault) {
    FaultCount& of_kind = measurement_.faults[fault.kind];
    if (of_kind.count++ == 0) of_kind.message = fault.message;
  }

  void add_output(const Estimate& output) {
    if (measurement_.outputs++ == 0) first_ = output;
    value_ += difference(output, first_.value);
    if (truth_ == nullptr) return;
    const Eigen::VectorXd error = difference(output, truth_->value);
    sum_ += error;
    squares_ += error.cwiseAbs2();
    measurement_.inside += is_inside(error);
    if (study_.recorded) return;
    const Eigen::MatrixXd covariance = independent_covariance(output, *truth_);
    measurement_.consistency.add(normalized_squared_error(error, covariance));
    constexpr double two_sided_95 = 1.959963984540054;
    for (Eigen::Index c = 0; c < error.size(); ++c)
      covered_[c] += std::abs(error[c]) <= two_sided_95 * std::sqrt(covariance(c, c)) ? 1 : 0;
  }

  void finish() {
    if (measurement_.outputs == 0) return;
    const auto n = static_cast<double>(measurement_.outputs);
    const Eigen::VectorXd offset = value_ / n;
    measurement_.value = retract(*study_.payload, first_.value,
                                 std::span(offset.data(), study_.payload->dimension()));
    if (truth_ == nullptr) return;
    for (Eigen::Index c = 0; c < dimension(); ++c) {
      const double bias = sum_[c] / n;
      const double scatter = std::max(0.0, squares_[c] - n * bias * bias);
      measurement_.errors.push_back({bias, n > 1 ? std::sqrt(scatter / (n - 1)) : 0,
                                     std::sqrt(squares_[c] / n), covered_[c] / n});
    }
  }

 private:
  Eigen::Index dimension() const { return static_cast<Eigen::Index>(study_.payload->dimension()); }
  bool is_inside(const Eigen::VectorXd& error) const {
    for (std::size_t c = 0; c < study_.requirement.size(); ++c)
      if (study_.requirement[c] &&
          !(std::abs(error[static_cast<Eigen::Index>(c)]) <= *study_.requirement[c]))
        return false;
    return true;
  }

  const Study& study_;
  const Estimate* truth_;
  CaseMeasurement& measurement_;
  Estimate first_;
  Eigen::VectorXd value_;  // of outputs ⊖ first output, summed
  Eigen::VectorXd sum_;
  Eigen::VectorXd squares_;
  Eigen::VectorXd covered_;
};

CasePrediction predict(const Plan& plan, std::uint64_t seed) {
  CasePrediction prediction;
  prediction.time = predict_time(plan, Execution::one_thread);
  for (const std::size_t node : prediction.time.unknown)
    prediction.unknown.push_back(plan.nodes[node].name);
  System system(plan, seed);
  system.expect();
  const NodeState& output = system.node(plan.outputs.front());
  if (!output.outcome.has_output()) {
    prediction.fault = output.outcome.is_fault()
                           ? output.outcome.fault()
                           : Fault{FaultKind::no_error_known, "no output is expected"};
    return prediction;
  }
  const Estimate& estimate = output.output().estimate;
  prediction.value = estimate.value;
  for (std::size_t c = 0; c < estimate.dimension(); ++c)
    prediction.standard_deviation.push_back(estimate.lineage.standard_deviation(c));
  prediction.verdict = judge(system).front();
  return prediction;
}

void run(const Study& study, const Plan& plan, std::uint64_t seed, ErrorCollector& errors,
         CaseMeasurement& measurement) {
  const CycleClock& clock = CycleClock::instance();
  System system(plan, seed);
  const std::size_t output = plan.outputs.front();
  measurement.time.emplace();
  Estimate drawn;
  for (std::int64_t r = 0; r < study.runs; ++r) {
    const std::uint64_t start = clock.now();
    system.evaluate(time_at(static_cast<double>(r)));
    measurement.time->record(clock.nanoseconds(start, clock.now()));
    const NodeState& state = system.node(output);
    if (state.outcome.is_pending()) {
      ++measurement.pending;
    } else if (state.outcome.is_fault()) {
      errors.add_fault(state.outcome.fault());
    } else if (!study.draw_systematic_errors) {
      errors.add_output(state.output().estimate);
    } else {
      const auto run_seed = derive_seed(seed, static_cast<std::uint64_t>(r));
      if (const Outcome<> outcome = draw_systematic_errors(system, run_seed, drawn))
        errors.add_output(drawn);
      else if (outcome.is_fault())
        errors.add_fault(outcome.fault());
      else
        ++measurement.pending;
    }
  }
}

/// The truth in a case: its recorded value, or one tick of its system.
Outcome<Estimate> true_value(const StudySource& truth, std::uint64_t seed) {
  if (const auto* recorded = std::get_if<Outcome<Estimate>>(&truth)) return *recorded;
  const Plan& plan = std::get<Plan>(truth);
  System system(plan, seed);
  system.evaluate(Time{});
  const NodeState& state = system.node(plan.outputs.front());
  if (state.outcome.is_fault()) return state.outcome.fault();
  if (state.outcome.is_pending()) return Pending{};
  return state.output().estimate;
}

CaseAlternative measure_alternative(const Study& study, const StudySource& source,
                                    const Estimate* truth, std::uint64_t seed) {
  CaseAlternative result;
  CaseMeasurement& measurement = result.measurement;
  ErrorCollector errors(study, truth, measurement);
  measurement.runs = study.runs;
  if (const auto* recorded = std::get_if<Outcome<Estimate>>(&source)) {
    if (recorded->has_output())
      errors.add_output(**recorded);
    else
      errors.add_fault(recorded->fault());
  } else {
    const Plan& plan = std::get<Plan>(source);
    result.prediction = predict(plan, seed);
    run(study, plan, seed, errors, measurement);
  }
  errors.finish();
  result.judged = truth != nullptr && study.has_requirement();
  for (std::size_t c = 0; c < measurement.errors.size(); ++c) {
    const ComponentErrors& made = measurement.errors[c];
    // A NaN compares false, and is a miss.
    if (study.requirement[c] && !(made.rms <= *study.requirement[c]))
      result.misses.push_back({c, study.recorded ? made.bias : made.rms, *study.requirement[c]});
  }
  result.meets_requirement = result.judged && measurement.outputs > 0 && result.misses.empty();
  return result;
}

void summarise(const Study& study, Comparison& comparison) {
  for (std::size_t a = 0; a < study.alternatives.size(); ++a) {
    AlternativeSummary& summary = comparison.summary.emplace_back();
    std::vector<double> squares(study.payload->dimension(), 0.0);
    for (const ComparedCase& one : comparison.cases) {
      const CaseAlternative& alternative = one.alternatives[a];
      summary.judged += alternative.judged;
      summary.met += alternative.meets_requirement;
      const std::vector<ComponentErrors>& errors = alternative.measurement.errors;
      if (errors.empty()) continue;
      ++summary.cases;
      for (std::size_t c = 0; c < squares.size(); ++c) squares[c] += errors[c].rms * errors[c].rms;
    }
    if (summary.cases > 0)
      for (const double sum : squares)
        summary.rms.push_back(std::sqrt(sum / static_cast<double>(summary.cases)));
    const auto cases = static_cast<std::int64_t>(comparison.cases.size());
    comparison.requirement_met &= !study.has_requirement() || summary.met == cases;
  }
}

}  // namespace

Comparison compare(const Study& study) {
  Comparison comparison;
  for (const StudyCase& one : study.cases) {
    const auto seed_of = [&](std::string_view who) {
      return derive_seed(derive_seed(study.seed, who), one.name);
    };
    ComparedCase& compared = comparison.cases.emplace_back();
    compared.name = one.name;
    const Outcome<Estimate> truth = true_value(one.truth, seed_of("truth"));
    if (truth.has_output())
      compared.truth = truth->value;
    else
      compared.truth_fault =
          truth.is_fault() ? truth.fault() : Fault{FaultKind::no_detection, "nothing is due yet"};
    for (std::size_t a = 0; a < one.alternatives.size(); ++a)
      compared.alternatives.push_back(measure_alternative(study, one.alternatives[a],
                                                          truth.has_output() ? &*truth : nullptr,
                                                          seed_of(study.alternatives[a])));
  }
  summarise(study, comparison);
  return comparison;
}

}  // namespace ilss
