#include "src/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <optional>

#include "framework/module/document.h"
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

}  // namespace

Option Option::required() {
  option_->required();
  return *this;
}

Option Option::type_name(const std::string& name) {
  option_->type_name(name);
  return *this;
}

Option Option::one_value_each() {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::check(OptionCheck check) {
  option_->transform(CLI::Validator(std::move(check), ""));
  return *this;
}

Option Option::one_of(std::initializer_list<std::string> values) {
  option_->check(CLI::IsMember(std::vector<std::string>(values)));
  return *this;
}

Option Option::show_default() {
  option_->capture_default_str();
  return *this;
}

Option Option::needs(Option other) {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(Option other) {
  option_->excludes(other.option_);
  return *this;
}

Verb Verb::add_verb(const std::string& name, const std::string& description) {
  return Verb(app_->add_subcommand(name, description));
}

void Verb::require_verb() { app_->require_subcommand(1); }

template <typename T>
Option Verb::add_option(const std::string& name, T& value, const std::string& description) {
  return Option(app_->add_option(name, value, description));
}

template Option Verb::add_option(const std::string&, std::string&, const std::string&);
template Option Verb::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Verb::add_option(const std::string&, int&, const std::string&);
template Option Verb::add_option(const std::string&, unsigned&, const std::string&);
template Option Verb::add_option(const std::string&, double&, const std::string&);
template Option Verb::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option Verb::add_option(const std::string&, std::optional<std::int64_t>&,
                                 const std::string&);
template Option Verb::add_option(const std::string&, std::optional<std::uint64_t>&,
                                 const std::string&);

Option Verb::add_flag(const std::string& name, bool& value, const std::string& description) {
  return Option(app_->add_flag(name, value, description));
}

void Verb::add_set_option(std::vector<std::string>& sets) {
  add_option("--set", sets, "Override a parameter (or constants.NAME) of the graph")
      .type_name("MODULE.PARAMETER=VALUE")
      .one_value_each();
}

void Verb::on_call(std::function<void()> action) { app_->callback(std::move(action)); }

/// CLI11 itself wraps or clamps what does not fit and reads a leading 0 as octal.
template <typename T>
OptionCheck whole_number(T least, T most) {
  return [least, most](std::string& text) -> std::string {
    T value{};
    const char* text_end = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), text_end, value);
    if (error != std::errc{} || end != text_end || value < least || value > most)
      return fmt::format("'{}' is not a whole number from {} to {}", text, least, most);
    text = std::to_string(value);
    return {};
  };
}

template OptionCheck whole_number(int, int);
template OptionCheck whole_number(unsigned, unsigned);
template OptionCheck whole_number(std::int64_t, std::int64_t);
template OptionCheck whole_number(std::uint64_t, std::uint64_t);

int call_verb(int argc, char** argv, const std::string& description,
              const std::function<void(Verb command)>& declare) {
  CLI::App app(description);
  app.set_version_flag("--version", "ilss " ILSS_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.failure_message(usage_message);
  declare(Verb(&app));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_fine : exit_bad_input;
  } catch (const Exit& exit) {
    return exit.status;
  }
  return exit_fine;
}

}  // namespace ilss
