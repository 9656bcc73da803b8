// What every verb of the command shares: the registry, plug-ins, reading graphs, exit statuses.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <concepts>
#include <filesystem>
#include <string>
#include <vector>

#include "framework/graph/plan.h"

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

/// The option `--set MODULE.PARAMETER=VALUE`, the same in every verb that takes a graph.
void add_set_option(CLI::App& verb, std::vector<std::string>& sets);

/// Accepts whole numbers in the range, in decimal digits; CLI11 itself wraps or clamps what does
/// not fit and reads a leading 0 as octal.
template <std::integral T>
CLI::Validator whole_number(T least, T most) {
  const auto read = [least, most](std::string& text) -> std::string {
    T value{};
    const char* text_end = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), text_end, value);
    if (error != std::errc{} || end != text_end || value < least || value > most)
      return fmt::format("'{}' is not a whole number from {} to {}", text, least, most);
    text = std::to_string(value);
    return {};
  };
  return {read, ""};
}

/// Each adds its verb to the command.
void add_check(CLI::App& app, Session& session);
void add_modules(CLI::App& app, Session& session);
void add_eval(CLI::App& app, Session& session);
void add_predict(CLI::App& app, Session& session);
void add_run(CLI::App& app, Session& session);
void add_compare(CLI::App& app, Session& session);
void add_calibrate(CLI::App& app);
void add_graph(CLI::App& app, Session& session);
void add_schema(CLI::App& app, Session& session);

/// Ends the command with a usage error where the file of an output option is one of the command's
/// inputs, or is there already and no regular file; nothing is touched.
void check_output_file(const std::string& option, const std::string& path,
                       const std::vector<std::string>& inputs);

}  // namespace ilss
