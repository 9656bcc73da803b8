// A study of sets carried out: what each alternative found of the truth, and how well.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "framework/estimate/consistency.h"
#include "framework/runtime/latency_histogram.h"
#include "framework/study/comparison.h"
#include "framework/study/study.h"

namespace ilss {

/// The errors (found - truth) of one component over all matches.
struct MatchedErrors {
  double bias = 0;                ///< their mean
  double standard_deviation = 0;  ///< around the bias; 0 of a single match
  double median = 0;              ///< of their sizes
};

/// What an alternative made of the elements of one payload in a case.
struct ElementScore {
  std::int64_t truth = 0;
  std::int64_t found = 0;
  std::int64_t matched = 0;
  std::int64_t tolerated = 0;  ///< found, no match of the truth, but of what is tolerated
  std::vector<MatchedErrors> errors = {};  ///< of the judged components; empty without matches
  double median_distance = 0;              ///< of places (m); 0 where matched by readings
  ConsistencyStatistic consistency = {};   ///< NEES of the judged components together
  std::int64_t inside_95 = 0;              ///< matches inside their 95 % ellipse
  std::int64_t inside_gate = 0;            ///< matches inside the study's own gate
  /// By the study's reference: of the matches that both have, this alternative's sd over the
  /// reference's, a judged component; empty without a reference or common matches.
  std::vector<double> relative_deviation = {};

  /// Share of the truth that was found.
  double true_positive() const { return share(matched, truth); }
  /// Share of what was found that is neither true nor tolerated.
  double false_positive() const { return share(found - matched - tolerated, found); }
  double inside_95_share() const { return share(inside_95, matched); }
  double inside_gate_share() const { return share(inside_gate, matched); }
  /// Mean NEES of a match, and where it lies with the given probability if errors are honest.
  double mean_nees() const;
  Interval nees_bounds(double probability) const;

 private:
  static double share(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  }
};

/// What an alternative did in a case.
struct SetAlternative {
  std::int64_t outputs = 0;
  std::int64_t pending = 0;
  std::map<FaultKind, FaultCount> faults = {};
  LatencyHistogram time = {};             ///< of each run but for its simulated sensors (ns)
  std::vector<ElementScore> scores = {};  ///< in the order of Study::judged
};

struct SetCase {
  std::string name;
  std::int64_t ticks = 0;  ///< with a truth
  std::map<FaultKind, FaultCount> truth_faults = {};
  std::vector<SetAlternative> alternatives = {};  ///< in the order of Study::alternatives
};

/// Carries out a study of sets: the truth, what is tolerated and each alternative run `runs` ticks
/// under the study's seed, the same for all, so that modules of one name draw the same: a
/// simulated sensor in an alternative and the module of its name in the truth see the same world.
/// Tick by tick the elements are matched (set_matching.h), those that match nothing true with what
/// is tolerated. Where the truth has a fault, a tick is left out; where an alternative has one, it
/// has found nothing. Constants are not drawn.
std::vector<SetCase> compare_sets(const Study& study);

}  // namespace ilss
