// A study carried out: what each alternative promised and what it did, case by case.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "framework/estimate/consistency.h"
#include "framework/runtime/latency_histogram.h"
#include "framework/semantics/time_prediction.h"
#include "framework/semantics/verdict.h"
#include "framework/study/study.h"

namespace ilss {

/// What was known of a system in a case before it ran.
struct CasePrediction {
  std::optional<Fault> fault = {};              ///< why there is no prediction
  std::vector<double> value = {};               ///< expected output (SI)
  std::vector<double> standard_deviation = {};  ///< its first-order error
  std::optional<VerdictReport> verdict = {};
  TimePrediction time = {};               ///< in one thread, as it is measured
  std::vector<std::string> unknown = {};  ///< modules whose time nothing declares
  bool time_known() const { return unknown.empty(); }
};

/// The errors (estimate ⊖ truth) of one component over all outputs of a case.
struct ComponentErrors {
  double bias = 0;                ///< their mean
  double standard_deviation = 0;  ///< around the bias; 0 of a single output
  double rms = 0;
  double coverage = 0;  ///< share within 1.96 stated standard deviations; honest: 0.95
};

/// How often a fault of one kind came, and what the first one said.
struct FaultCount {
  std::int64_t count = 0;
  std::string message;
};

/// What an alternative did in a case.
struct CaseMeasurement {
  std::int64_t runs = 0;
  std::int64_t outputs = 0;
  std::int64_t pending = 0;
  std::map<FaultKind, FaultCount> faults = {};
  std::vector<double> value = {};             ///< mean output (SI); empty without outputs
  std::vector<ComponentErrors> errors = {};   ///< empty without outputs or truth
  std::int64_t inside = 0;                    ///< runs with every error within the requirement
  ConsistencyStatistic consistency = {};      ///< NEES; of no runs where no error is stated
  std::optional<LatencyHistogram> time = {};  ///< compute time of each run (ns)
};

/// A component whose RMS error (of a recorded value: whose error) is larger than is required.
struct Miss {
  std::size_t component;
  double error;  ///< with its sign where it is of a single value
  double limit;
  double excess() const { return std::abs(error) - limit; }
};

/// One alternative in one case.
struct CaseAlternative {
  std::optional<CasePrediction> prediction = {};  ///< of systems
  CaseMeasurement measurement = {};
  bool judged = false;             ///< whether there was a truth and a requirement to judge it by
  bool meets_requirement = false;  ///< no miss, and an output at all
  std::vector<Miss> misses = {};
};

struct ComparedCase {
  std::string name;
  std::optional<Fault> truth_fault = {};
  std::vector<double> truth = {};  ///< SI; empty where it has a fault
  std::vector<CaseAlternative> alternatives = {};
};

/// One alternative over all cases.
struct AlternativeSummary {
  std::vector<double> rms = {};  ///< of the cases' RMS errors, a component; empty without any
  std::int64_t cases = 0;        ///< with outputs and truth
  std::int64_t judged = 0;
  std::int64_t met = 0;
};

struct Comparison {
  std::vector<ComparedCase> cases;
  std::vector<AlternativeSummary> summary;  ///< in the order of Study::alternatives
  bool requirement_met = true;              ///< by every alternative in every case; a case
                                            ///< without truth shows nothing of the sort
};

/// The probability that NEES is tested with.
inline constexpr double consistency_probability = 0.99;

/// Carries out a study. A system is predicted (System::expect, judge, predict_time), then run
/// `runs` times with fresh noise that follows from the study's seed and the names of alternative
/// and case. Its errors are taken against one tick of the truth, by the payload's own
/// difference; NEES uses the stated covariance and the truth's own. Faults are counted, never
/// fatal. A system's random errors only are drawn where the study says so, else its constants' too.
Comparison compare(const Study& study);

}  // namespace ilss
