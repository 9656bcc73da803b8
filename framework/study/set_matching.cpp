#include "framework/study/set_matching.h"

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

/// A pair that may be one thing; a lower cost is a better match.
struct Candidate {
  double cost;
  ElementMatch match;
};

std::optional<double> interval_cost(const ElementRule& rule, const Estimate& a, const Estimate& b) {
  const auto [first, last] = *rule.interval;
  const double overlap =
      interval_overlap(a.value[first], a.value[last], b.value[first], b.value[last]);
  if (!(overlap >= rule.overlap)) return std::nullopt;
  return 1 - overlap;
}

std::optional<double> place_cost(const ElementRule& rule, const Estimate& a, const Estimate& b) {
  if (a.labels != b.labels) return std::nullopt;
  const double squared = difference(a, b.value)(rule.place).squaredNorm();
  if (!(squared <= rule.gate * rule.gate)) return std::nullopt;
  return std::sqrt(squared);
}

}  // namespace

bool ElementRule::applies_to(const Estimate& element) const {
  return element.type->name == type->name &&
         std::all_of(only.begin(), only.end(), [&](const auto& label) {
           return label.first < element.labels.size() &&
                  element.labels[label.first] == label.second;
         });
}

ElementRule element_rule(const PayloadDescriptor& type) {
  ElementRule rule;
  rule.type = &type;
  const auto first = type.find("first_reading");
  const auto last = type.find("last_reading");
  if (first && last) {
    rule.interval.emplace(*first, *last);
    return rule;
  }
  const auto x = type.find("x");
  for (const char* other : {"z", "y"})
    if (const auto second = type.find(other); x && second && rule.place.empty())
      rule.place = {*x, *second};
  return rule;
}

double interval_overlap(double first_a, double last_a, double first_b, double last_b) {
  const double common = std::min(last_a, last_b) - std::max(first_a, first_b) + 1;
  if (!(common > 0)) return 0;
  return common / (last_a - first_a + 1 + last_b - first_b + 1 - common);
}

std::vector<ElementMatch> match_elements(const ElementRule& rule,
                                         std::span<const Estimate* const> truth,
                                         std::span<const Estimate* const> found) {
  std::vector<Candidate> candidates;
  for (std::size_t t = 0; t < truth.size(); ++t)
    for (std::size_t f = 0; f < found.size(); ++f) {
      const auto cost = rule.interval ? interval_cost(rule, *truth[t], *found[f])
                                      : place_cost(rule, *truth[t], *found[f]);
      if (cost) candidates.push_back({*cost, {t, f}});
    }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  std::vector<char> truth_matched(truth.size(), 0);
  std::vector<char> found_matched(found.size(), 0);
  std::vector<ElementMatch> matches;
  for (const auto& [cost, match] : candidates) {
    if (truth_matched[match.truth] || found_matched[match.found]) continue;
    truth_matched[match.truth] = found_matched[match.found] = 1;
    matches.push_back(match);
  }
  std::sort(matches.begin(), matches.end(),
            [](const ElementMatch& a, const ElementMatch& b) { return a.truth < b.truth; });
  return matches;
}

}  // namespace ilss
