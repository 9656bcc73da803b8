// A study: alternatives side by side, each in the same cases, with the truth and what is required.
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "framework/graph/plan.h"
#include "framework/study/set_matching.h"

namespace ilss {

/// Where the truth or an alternative gets its value in one case: a recorded value (a fault where
/// the recording has none), or a system to run.
using StudySource = std::variant<Outcome<Estimate>, Plan>;

/// One situation in which all alternatives are compared.
struct StudyCase {
  std::string name;
  StudySource truth;
  std::vector<StudySource> alternatives;  ///< in the order of Study::alternatives
  std::optional<Plan> tolerated = {};     ///< of sets: what is no mistake to find
};

/// A study after every check has passed.
struct Study {
  std::string name;
  std::string description;
  const PayloadDescriptor* payload = nullptr;      ///< what is compared
  std::vector<std::optional<double>> requirement;  ///< largest error of each component (SI)
  std::vector<std::string> alternatives;
  std::string case_noun = "case";  ///< what a case is called: "pose"
  std::vector<StudyCase> cases;
  bool recorded = false;  ///< values from recordings; else from systems
  std::int64_t runs = 1;  ///< of each system in each case
  std::uint64_t seed = 1;
  bool draw_systematic_errors = true;  ///< whether constants are wrong by another draw in each run

  std::vector<ElementRule> judged = {};        ///< of sets: how elements are judged
  std::optional<double> validation_gate = {};  ///< of sets: a chi² to count matches within
  std::optional<std::size_t> reference = {};   ///< of sets: the alternative to relate sd to

  bool compares_sets() const { return !payload->element.empty(); }
  bool has_requirement() const {
    return std::any_of(requirement.begin(), requirement.end(),
                       [](const auto& limit) { return limit.has_value(); });
  }
};

/// Reads a study file, its recordings and its graphs. Everything that is wrong goes to
/// `diagnostics`, all in one go; no module's code runs. Nothing is returned if anything is wrong.
std::optional<Study> read_study(const std::filesystem::path& file, const Registry& registry,
                                Diagnostics& diagnostics);

}  // namespace ilss
