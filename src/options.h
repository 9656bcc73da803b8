// The command line, as verbs declare it. CLI11 reads it and is known in options.cpp alone: each
// file that includes it takes 7 s longer to compile.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace ilss {

/// Looks at what was written for an option and may rewrite it. @return what is wrong, or nothing
using OptionCheck = std::function<std::string(std::string& text)>;

/// A handle of one option or positional argument of a verb.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option required();
  /// How help calls the value: "FILE".
  Option type_name(const std::string& name);
  /// Of an option that may be repeated: each takes one value, and no positional argument after it.
  Option one_value_each();
  Option check(OptionCheck check);
  Option one_of(std::initializer_list<std::string> values);
  /// Help shows the value that the variable has now.
  Option show_default();
  Option needs(Option other);
  Option excludes(Option other);

 private:
  CLI::Option* option_;
};

/// A handle of the command, or of one of its verbs.
class Verb {
 public:
  explicit Verb(CLI::App* app) : app_(app) {}

  Verb add_verb(const std::string& name, const std::string& description);
  /// One of its verbs must be given.
  void require_verb();
  /// An option ("--ticks") or a positional argument ("GRAPH") that sets `value` where it is given:
  /// a string, strings, a number, or an optional number.
  template <typename T>
  Option add_option(const std::string& name, T& value, const std::string& description);
  Option add_flag(const std::string& name, bool& value, const std::string& description);
  /// `--set MODULE.PARAMETER=VALUE`, the same in every verb that takes a graph.
  void add_set_option(std::vector<std::string>& sets);
  /// What the verb does, once the whole command line has been read.
  void on_call(std::function<void()> action);

 private:
  CLI::App* app_;
};

/// Accepts whole numbers in the range, in decimal digits.
template <typename T>
OptionCheck whole_number(T least, T most);

/// Reads the command line into what `declare` adds to the command, and calls the verb.
/// @return the exit status
int call_verb(int argc, char** argv, const std::string& description,
              const std::function<void(Verb command)>& declare);

}  // namespace ilss
