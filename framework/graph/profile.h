// Profiles: how long modules take, as declared in a graph or as measured by a run.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/plan.h"

namespace ilss {

/// One module's time, by its name in the plan.
struct ProfileEntry {
  std::string module;
  ModuleTime time = {};
  Position position = {};  ///< in the profile's file; line 0 where it was measured just now
};

/// What a run found out about its modules' times; prediction takes them instead of declared ones.
struct Profile {
  std::string plan = {};  ///< the name of the plan that ran
  std::vector<ProfileEntry> modules = {};
};

/// Reads a module's time: `20 us`, or `{typical: 20 us, worst: 1 ms}`.
std::optional<ModuleTime> read_module_time(const Node& node, Diagnostics& diagnostics);

/// Writes `profile: PLAN` and `modules: {NAME: {typical: TIME, worst: TIME}}` as YAML, times to the
/// last digit.
void write_profile(const Profile& profile, std::ostream& out);

/// Reads what `write_profile` wrote; what is wrong goes to `diagnostics`.
Profile read_profile(const std::filesystem::path& file, Diagnostics& diagnostics);

/// Replaces the declared times of the modules in `profile`; others keep theirs. A module that the
/// plan does not have goes to `diagnostics`.
void apply_profile(const Profile& profile, Plan& plan, Diagnostics& diagnostics);

}  // namespace ilss
