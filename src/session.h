// What every verb of the command shares: the registry, plug-ins, reading graphs, exit statuses.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "framework/graph/plan.h"
#include "src/options.h"

namespace ilss {

/// Exit statuses of the command.
inline constexpr int exit_fine = 0;
inline constexpr int exit_failed =
    1;  ///< the run could not go on, or an enforced requirement failed
inline constexpr int exit_bad_input = 2;  ///< bad usage or input

/// Ends a verb with an exit status; what there was to say has been said.
struct Exit {
  int status;
};

/// One call of the command.
struct Session {
  Registry registry;
  std::vector<std::string> plugins;

  /// Registers the built-in modules and loads the plug-ins. @throws Exit
  void load_modules();
  /// Reads a graph with `--set` overrides. Prints every error. @throws Exit
  Plan read_graph(const std::filesystem::path& file, const std::vector<std::string>& sets) const;
  /// Replaces the plan's module times by those of a profile. Prints every error. @throws Exit
  void apply_profile_file(const std::filesystem::path& file, Plan& plan);
};

/// Prints diagnostics to stderr, each as file:line:column: message, and ends with status 2.
[[noreturn]] void report_and_exit(const Diagnostics& diagnostics);
/// Prints one message to stderr and ends with the status.
[[noreturn]] void fail(int status, const std::string& message);

/// Each adds its verb to the command.
void add_check(Verb command, Session& session);
void add_modules(Verb command, Session& session);
void add_eval(Verb command, Session& session);
void add_predict(Verb command, Session& session);
void add_run(Verb command, Session& session);
void add_compare(Verb command, Session& session);
void add_calibrate(Verb command);
void add_graph(Verb command, Session& session);
void add_schema(Verb command, Session& session);

/// Ends the command with a usage error where the file of an output option is one of the command's
/// inputs, or is there already and no regular file; nothing is touched.
void check_output_file(const std::string& option, const std::string& path,
                       const std::vector<std::string>& inputs);

}  // namespace ilss
