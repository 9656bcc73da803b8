// A command as its module declares it: a name, its one value, and what it does.
#pragma once

#include <string>
#include <vector>

#include "framework/module/parameters.h"

namespace ilss {

/// A command that a module follows: its name and its one value, declared like a parameter. The
/// value is a quantity (in the SI unit), number, integer, boolean, text or choice.
struct CommandDeclaration {
  std::string name;
  ParameterDeclaration value;
  std::string documentation;
};

/// Commands declared on one line each:
/// `return {quantity_command("rotate_to", "rad", "turns the head to this angle")};`
/// The comments say what the module's `command` finds in `Command::value`.
CommandDeclaration quantity_command(std::string name, std::string si_unit,
                                    std::string documentation);                   ///< double
CommandDeclaration number_command(std::string name, std::string documentation);   ///< double
CommandDeclaration integer_command(std::string name, std::string documentation);  ///< std::int64_t
CommandDeclaration boolean_command(std::string name, std::string documentation);  ///< bool
CommandDeclaration text_command(std::string name, std::string documentation);     ///< std::string
/// One of these words, as std::string.
CommandDeclaration choice_command(std::string name, std::vector<std::string> choices,
                                  std::string documentation);

/// Why a type cannot declare these commands; empty where it can: names are words of their own,
/// without dots, spaces, '=' and '@', and values are of the kinds above.
std::string mistake_in(const std::vector<CommandDeclaration>& commands);

/// Whether a command may have this name: a word without dots, spaces, slashes, '$', '=' and '@'.
bool can_name_command(std::string_view name);

}  // namespace ilss
