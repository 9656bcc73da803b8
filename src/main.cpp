// The `ilss` command: one verb a file.
#include <fmt/format.h>

#include <exception>

#include "src/session.h"

int main(int argc, char** argv) {
  CLI::App app{
      "ilss: networks of logical sensors whose outputs say how late and how wrong they are"};
  app.set_version_flag("--version", "ilss 0.1.0");
  app.require_subcommand(1);
  app.fallthrough();
  ilss::Session session;
  app.add_option("--plugin", session.plugins, "Load module types from a shared library")
      ->type_name("LIBRARY")
      ->allow_extra_args(false);
  ilss::add_check(app, session);
  ilss::add_modules(app, session);
  ilss::add_eval(app, session);
  ilss::add_predict(app, session);
  ilss::add_run(app, session);
  ilss::add_compare(app, session);
  ilss::add_graph(app, session);
  ilss::add_schema(app, session);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? ilss::exit_fine : ilss::exit_bad_input;
  } catch (const ilss::Exit& exit) {
    return exit.status;
  } catch (const std::exception& error) {
    fmt::print(stderr, "ilss: internal error: {}\n", error.what());
    return ilss::exit_failed;
  }
  return ilss::exit_fine;
}
