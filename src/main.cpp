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

/// Reads the command line and does what it says.
int do_verb(int argc, char** argv) {
  Session session;
  return call_verb(
      argc, argv,
      "ilss: networks of logical sensors whose outputs say how late and how wrong they are",
      [&session](Verb command) {
        command.add_option("--plugin", session.plugins, "Load module types from a shared library")
            .type_name("LIBRARY")
            .one_value_each();
        add_check(command, session);
        add_modules(command, session);
        add_eval(command, session);
        add_predict(command, session);
        add_run(command, session);
        add_compare(command, session);
        add_calibrate(command);
        add_graph(command, session);
        add_schema(command, session);
      });
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
