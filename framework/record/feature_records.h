// The formats in which feature sets are written and read: CSV, a row an element, and JSON, a set a
// line.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/estimate/estimate.h"
#include "framework/module/outcome.h"

namespace ilss {

/// A source of error as a file tells it: who owned it in the recorded system, and when it was drawn
/// there; a persistent one is the same in all sets of the file.
struct RecordedSource {
  std::string owner;
  std::uint32_t column = 0;
  std::int64_t tick = 0;  ///< or `persistent_tick`

  bool operator==(const RecordedSource&) const = default;
};

/// A feature as a file tells it. `factor` is M x K with covariance = factor factorᵀ. Where the file
/// tells of sources, its columns are of `sources`, by their places in the set's list; otherwise
/// they are errors of the feature's own, as many as its rank.
struct RecordedFeature {
  const PayloadDescriptor* type = nullptr;
  std::vector<double> value = {};
  std::vector<int> labels = {};
  Eigen::MatrixXd factor = {};
  std::vector<std::size_t> sources = {};
};

/// When a set was seen: its tick, and how long before that tick's time (s, not negative).
struct RecordedTime {
  std::int64_t tick = 0;
  double age = 0;
};

/// F with F Fᵀ = covariance, of as many columns as its rank: by the eigenvectors of the
/// correlations, so that singular covariances and components of any unit keep their digits (to
/// rounding, in units of both components' standard deviations). Faults: bad_data where the
/// covariance is not symmetric or not positive semidefinite, both within 1e-6 of the correlations
/// (what a program that writes seven digits leaves of a singular one).
Outcome<Eigen::MatrixXd> covariance_factor(const Eigen::MatrixXd& covariance);

/// The columns of a CSV file of features: `tick, time, acquired, frame, type`, a column for every
/// label and every component of a set's element types, then `covariance.A.B` for every two
/// components A and B of one type (the upper triangle, in the order of the components). What an
/// element's type does not have is empty. Two elements' common errors have no place here.
class FeatureColumns {
 public:
  struct Row {
    RecordedTime time;
    RecordedFeature feature;
  };

  /// All columns of a set that declares the types of its elements, to write.
  explicit FeatureColumns(const PayloadDescriptor& set);

  /// The header's line.
  std::string header() const;
  /// An element's line; `leading` is its tick, time and time of acquisition.
  /// @throws std::invalid_argument where its type is none of the set's.
  std::string line(std::string_view leading, const Estimate& element) const;

  /// Reads the header. `set` declares the types of elements. Columns of other names are left alone.
  /// Faults: device_lost where `tick` or `type` is missing, a name comes twice, or a covariance is
  /// of no two components of one type in their order.
  static Outcome<FeatureColumns> read(std::string_view header, const PayloadDescriptor& set);

  /// The tick of a row, if there is one.
  std::optional<std::int64_t> tick_of(std::string_view row) const;

  /// Reads a row of a set in `frame`. A covariance's cell may be empty or its column missing where
  /// it is 0, but for the variances. Faults: bad_data, with what is wrong and in which column.
  Outcome<Row> parse(std::string_view row, std::string_view frame) const;

 private:
  static constexpr std::size_t missing = static_cast<std::size_t>(-1);

  /// In which columns a type's parts stand.
  struct Type {
    const PayloadDescriptor* type;
    std::vector<std::size_t> labels, components, covariances;  ///< of these the upper triangle
    std::vector<bool> has;                                     ///< of each column of the header
  };
  class Cells;

  FeatureColumns() = default;
  void place_types(const PayloadDescriptor& set,
                   const std::function<std::size_t(const std::string&)>& place);
  Outcome<RecordedFeature> read_feature(const Type& type, const Cells& cells) const;

  std::vector<std::string> names_;
  std::vector<Type> types_;
  std::size_t tick_ = missing, time_ = missing, acquired_ = missing, frame_ = missing,
              type_ = missing;
};

/// A set of features and when it was seen.
struct RecordedSet {
  RecordedTime time = {};
  std::vector<RecordedFeature> features = {};
  std::vector<RecordedSource> sources = {};  ///< that features have in common, where told
};

/// Reads a line of JSON: a tick's object as `ilss run --json` prints it or `--features` writes it,
/// with its set in `frame`. `sources` and each feature's `factor` over them may be absent, as in
/// files of other programs; then each feature has its covariance alone. Nothing for a line of an
/// array's brackets or a tick without an output.
/// Faults: bad_data.
Outcome<std::optional<RecordedSet>> parse_feature_json(std::string_view line,
                                                       const PayloadDescriptor& set,
                                                       std::string_view frame);

}  // namespace ilss
