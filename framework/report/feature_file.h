// The sets of features that a run gives, as a file for other programs.
#pragma once

#include <optional>
#include <ostream>

#include "framework/record/feature_records.h"
#include "framework/runtime/characteristic_output.h"

namespace ilss {

/// Writes the sets that a system's one output gives, a tick after the other, in SI units; a tick
/// without a set is left out.
///
/// CSV: a row an element, under a header that depends on the set's payload alone: FeatureColumns. A
/// tick whose set is empty has no row.
///
/// JSON: an array of a tick's object a line: `tick`, `time`, `acquired` and `output`, the set as
/// `ilss run --json` prints it, with its verdicts and what its elements have in common.
class FeatureFile final : public Observer {
 public:
  enum class Format { csv, json };

  /// `set` declares the types of its elements where the format is CSV.
  FeatureFile(std::ostream& stream, Format format, const PayloadDescriptor& set);

  OutputRange wants_verdicts(const TickView& tick) override {
    return {0, columns_ ? 0 : tick.outputs()};
  }
  void observe(const TickView& tick) override;
  /// Completes what was written.
  void finish();

 private:
  std::ostream& stream_;
  std::optional<FeatureColumns> columns_;  ///< of CSV
  bool any_ = false;
};

}  // namespace ilss
