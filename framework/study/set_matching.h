// Which element of a set is which of another: one-to-one, by the readings or the place they share.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "framework/estimate/estimate.h"

namespace ilss {

/// How elements of one payload are told apart, matched and judged.
struct ElementRule {
  const PayloadDescriptor* type = nullptr;
  std::vector<std::size_t> judged = {};  ///< components
  /// Components that hold the first and last of the readings that an element was made of (both
  /// included); without them, elements are matched by place.
  std::optional<std::pair<std::size_t, std::size_t>> interval = {};
  std::vector<std::size_t> place = {};  ///< components of a place (m); none with an interval
  double overlap = 0.7;                 ///< least intersection over union of intervals
  double gate = 0.1;                    ///< largest distance of places (m)
  std::vector<std::pair<std::size_t, int>> only = {};  ///< labels that elements must have

  bool applies_to(const Estimate& element) const;
};

/// The rule for a payload as its components' names have it: an interval where there are
/// `first_reading` and `last_reading`, a place where there are `x` and `z` or `x` and `y`.
ElementRule element_rule(const PayloadDescriptor& type);

/// Two elements that are one thing, by their indices.
struct ElementMatch {
  std::size_t truth = 0;
  std::size_t found = 0;
};

/// Intersection over union of two intervals of whole numbers, ends included.
double interval_overlap(double first_a, double last_a, double first_b, double last_b);

/// Matches `found` with `truth`, both of the rule's elements only: the best pair first (largest
/// overlap, or nearest), each element once; pairs below `overlap` or beyond `gate` never. Elements
/// matched by place must have equal labels. In the order of `truth`.
std::vector<ElementMatch> match_elements(const ElementRule& rule,
                                         std::span<const Estimate* const> truth,
                                         std::span<const Estimate* const> found);

}  // namespace ilss
