// The `ilss` command: one verb a file.
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <system_error>

#include "src/session.h"

namespace ilss {
namespace {

/// Bad usage, said as the command says all else: after its name, with what may have been meant.
std::string usage_message(const CLI::App* app, const CLI::Error& error) {
  const std::vector<std::string> rest = app->remaining();
  if (!app->get_subcommands().empty() || rest.empty())
    return "ilss: " + CLI::FailureMessage::simple(app, error);
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app->get_subcommands({})) verbs.push_back(verb->get_name());
  return fmt::format("ilss: unknown {} '{}'{}\nRun with --help for more information.\n",
                     rest.front().starts_with('-') ? "option" : "command", rest.front(),
                     suggestion(rest.front(), verbs));
}

/// Parses the command line and does what it says.
int do_verb(int argc, char** argv) {
  CLI::App app{
      "ilss: networks of logical sensors whose outputs say how late and how wrong they are"};
  app.set_version_flag("--version", "ilss 0.1.0");
  app.require_subcommand(1);
  app.fallthrough();
  app.failure_message(usage_message);
  Session session;
  app.add_option("--plugin", session.plugins, "Load module types from a shared library")
      ->type_name("LIBRARY")
      ->allow_extra_args(false);
  add_check(app, session);
  add_modules(app, session);
  add_eval(app, session);
  add_predict(app, session);
  add_run(app, session);
  add_compare(app, session);
  add_calibrate(app);
  add_graph(app, session);
  add_schema(app, session);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_fine : exit_bad_input;
  } catch (const Exit& exit) {
    return exit.status;
  }
  return exit_fine;
}

/// Says that standard output could not be written; a reader who has left knows.
int report_lost_output(int error) {
  if (error != EPIPE)
    std::fputs(fmt::format("ilss: cannot write the output: {}\n", std::strerror(error)).c_str(),
               stderr);
  return exit_failed;
}

}  // namespace
}  // namespace ilss

int main(int argc, char** argv) {
  try {
    const int status = ilss::do_verb(argc, argv);
    errno = 0;
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
    return ilss::report_lost_output(errno != 0 ? errno : EIO);
  } catch (const std::exception& error) {
    const auto* system_error = dynamic_cast<const std::system_error*>(&error);
    if (system_error != nullptr && std::ferror(stdout) != 0)
      return ilss::report_lost_output(system_error->code().value());
    std::fputs(fmt::format("ilss: internal error: {}\n", error.what()).c_str(), stderr);
    return ilss::exit_failed;
  }
}
