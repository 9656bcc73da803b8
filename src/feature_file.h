// `ilss run --features`: the sets of features that a run gives, as a file for other programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "framework/runtime/characteristic_output.h"
#include "src/output_file.h"

namespace ilss {

/// The sets of features that a run's one output gives, a tick after the other, in SI units. Written
/// whole or not at all.
///
/// CSV (`.csv`): a row an element, under a header that depends on the set's payload alone:
/// `tick, time, acquired, frame, type`, a column for every label and every component of its element
/// types, then `covariance.A.B` for every two components A and B of one type (the upper triangle,
/// in the order of the components). What an element's type does not have is empty. A tick whose set
/// is empty has no row.
///
/// JSON (`.json`): an array of a tick's object a line: `tick`, `time`, `acquired` and `output`, the
/// set as `ilss run --json` prints it.
class FeatureFile {
 public:
  /// Ends the command with status 2 where the plan's output is no set or the file's name says no
  /// format, and with what OutputFile says. @throws Exit
  FeatureFile(const std::string& path, const Plan& plan);

  /// Whether it holds verdicts.
  bool has_verdicts() const { return !columns_; }
  /// Adds the tick's set, where the tick has given one.
  void add(const TickView& tick);
  /// Puts the file in its place. @throws Exit
  void commit();

 private:
  /// The columns of a CSV file: where which type's labels, components and covariances stand.
  struct Columns {
    struct Type {
      const PayloadDescriptor* type;
      std::vector<std::size_t> labels, components, covariances;
    };
    std::vector<std::string> names;
    std::vector<Type> types;

    explicit Columns(const PayloadDescriptor& set);

   private:
    std::size_t place(const std::string& name);
  };

  void add_row(const Estimate& element, const std::string& tick);

  std::optional<Columns> columns_;  ///< of CSV
  std::size_t ticks_ = 0;
  std::optional<OutputFile> file_;
};

}  // namespace ilss
