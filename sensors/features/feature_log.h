// Feature sets from a file: what a run wrote, or another program.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "framework/module/module_type.h"
#include "framework/record/feature_records.h"
#include "framework/record/skipped_lines.h"
#include "framework/record/text_log.h"

namespace ilss {

/// Sensor: the range_features of a file, a set a tick in the order of the file: CSV or JSON as
/// `ilss run --features` writes them, or what `ilss run --json` prints, plain or compressed by
/// gzip. Rows of CSV that stand together and have one tick are a set. A tick that gave no set is
/// left out; ages (the time between acquisition and tick) are as recorded.
///
/// JSON tells which sources of error the elements of a set share, with each other and with other
/// sets of the file: a corner stays correlated with its lines, and a mount's error is one for all
/// ticks. CSV and files of other programs do not tell; there each element has its covariance,
/// singular or not, as fresh random sources of its own. What elements share with other outputs is
/// in no file: all say that their correlation is unknown, and fusion then keeps to covariance
/// intersection.
/// Faults, with file and line: bad_data where a row or line has a wrong count of cells, an unknown
/// type or label, another frame, no number where one belongs, a tick before the last one, or a
/// covariance that is not symmetric or not positive semidefinite; then the whole set is the fault,
/// and the next tick goes on behind it. With `skip_bad` bad rows (of JSON: lines, so whole sets)
/// are left out and counted. end_of_data after the last set; device_lost where the file cannot be
/// read, is empty or binary, or is no file of features.
class FeatureLog final : public Module {
 public:
  static constexpr std::string_view name = "feature_log";
  static constexpr std::string_view description = "feature sets from a file of features";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::end_of_data,
                                        FaultKind::device_lost};

  struct Options {
    std::filesystem::path file;
    std::string frame = "robot";
    bool skip_bad = false;
    void declare(OptionVisitor& visit);
  };

  static Interface interface(const Options& options);

  explicit FeatureLog(Options options) : options_(std::move(options)) {}

  Outcome<> open() override;
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  std::string note() const override { return skipped_.text(); }
  void reset() override;

 private:
  Outcome<std::optional<RecordedSet>> read_line();
  Outcome<std::optional<RecordedSet>> read_rows();
  bool is_left_out(std::string_view line) const;
  Fault at_line(std::size_t line, const Fault& fault) const;
  Fault out_of_order(std::int64_t tick) const;
  Source source_of(const RecordedSource& recorded);
  void emit(const Evaluation& evaluation, const RecordedSet& set, Output& output);

  Options options_;
  std::shared_ptr<const TextLog> log_;
  std::optional<FeatureColumns> columns_;  ///< of CSV
  std::size_t first_ = 0;                  ///< line behind the header
  std::size_t next_ = 0;                   ///< line
  std::int64_t last_tick_ = -1;
  bool any_ = false;  ///< set or fault given
  SkippedLines skipped_;
  std::uint32_t owner_ = 0;  ///< this module, of sources
  std::map<std::pair<std::string, std::uint32_t>, std::uint32_t> columns_of_sources_;
  std::map<std::int64_t, std::int64_t> given_ticks_;  ///< by the recorded ones
};

}  // namespace ilss
