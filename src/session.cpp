#include "src/session.h"

#include <fmt/format.h>

#include <cstdio>

#include "framework/graph/profile.h"
#include "sensors/register.h"

namespace ilss {

void Session::load_modules() {
  register_sensors(registry);
  for (const std::string& plugin : plugins) {
    try {
      load_plugin(plugin, registry);
    } catch (const std::exception& error) {
      fail(exit_bad_input, error.what());
    }
  }
}

Plan Session::read_graph(const std::filesystem::path& file,
                         const std::vector<std::string>& sets) const {
  Diagnostics diagnostics;
  std::vector<Override> overrides;
  for (const std::string& set : sets)
    if (auto parsed = parse_override(set, "--set " + set, diagnostics))
      overrides.push_back(std::move(*parsed));
  auto plan = read_plan(file, registry, overrides, diagnostics);
  if (!diagnostics.empty() || !plan) report_and_exit(diagnostics);
  return std::move(*plan);
}

void Session::apply_profile_file(const std::filesystem::path& file, Plan& plan) {
  Diagnostics diagnostics;
  const Profile profile = read_profile(file, diagnostics);
  apply_profile(profile, plan, diagnostics);
  if (!diagnostics.empty()) report_and_exit(diagnostics);
}

void report_and_exit(const Diagnostics& diagnostics) {
  for (const Diagnostic& diagnostic : diagnostics.sorted())
    fmt::print(stderr, "{}{}\n", diagnostic.position.file == nullptr ? "ilss: " : "",
               format_diagnostic(diagnostic));
  throw Exit{exit_bad_input};
}

void fail(int status, const std::string& message) {
  fmt::print(stderr, "ilss: {}\n", message);
  throw Exit{status};
}

void check_output_file(const std::string& option, const std::string& path,
                       const std::vector<std::string>& inputs) {
  std::error_code error;
  if (path.empty() || !std::filesystem::exists(path, error)) return;
  for (const std::string& input : inputs)
    if (std::filesystem::equivalent(path, input, error))
      fail(exit_bad_input, fmt::format("{}: '{}' is read by this command", option, path));
  if (!std::filesystem::is_regular_file(path, error))
    fail(exit_bad_input, fmt::format("{}: '{}' is not a regular file", option, path));
}

}  // namespace ilss
