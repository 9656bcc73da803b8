// Sets of features and samples as people read them: an element a line, and how many of what.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "framework/module/output.h"

namespace ilss {

/// Components and labels on one line: "rho 1044.7 ± 2.3 mm  readings 119  state ended".
std::string component_line(const Estimate& estimate);

/// How many samples there are: "240 readings", "480 rows x 640 columns"; "" where none.
std::string samples_text(const Output& output);

/// "2 line_segment, 1 corner" in order of the first of each; "no elements".
std::string element_counts_text(std::span<const Estimate> elements);

/// So many elements of a set are shown; of a set of more than `largest_shown_set` only how many
/// there are of which type.
inline constexpr std::size_t most_elements_shown = 12;
inline constexpr std::size_t largest_shown_set = 40;

/// The elements of a set, each on a line that begins with `indent`.
std::string elements_text(std::span<const Estimate> elements, const std::string& indent);

/// What an output holds beyond its components, for a single tick: how many samples, or each element
/// of a set with its correlations and who is to blame for its error.
std::string parts_text(const Output& output, const std::string& name, const SourceOwners& owners);

/// What the sets of many ticks held: how many elements of each type, and their stated errors.
class SetSummary {
 public:
  void add(std::span<const Estimate> elements);

  /// One type's part; standard deviations are root mean squares over all its elements.
  struct Entry {
    const PayloadDescriptor* type;
    std::uint64_t count = 0;
    std::vector<double> variance_sum = {};
  };
  const std::vector<Entry>& entries() const { return entries_; }  ///< in order of appearance

 private:
  std::vector<Entry> entries_;
};

/// "2 a tick: rho 2.2 mm, phi 0.16 deg"; exact components are left out.
std::string summary_text(const SetSummary::Entry& entry, std::uint64_t ticks);

}  // namespace ilss
