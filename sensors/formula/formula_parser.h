// Formulas as users write them, read onto a tape.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sensors/formula/tape.h"

namespace ilss {

/// What names in a formula stand for: arguments of the tape, by number.
using ArgumentNames = std::map<std::string, Tape::Index, std::less<>>;

/// What is wrong with a formula, and at which of its characters (from 0).
struct FormulaError {
  std::size_t offset;
  std::string message;
};

/// Whether a formula can use the name: a letter or _, then letters, digits and _.
bool is_formula_name(std::string_view name);
/// Whether formulas mean something by the name themselves: `sqrt`, `pi`, `rad`.
bool is_formula_word(std::string_view name);

/// Appends a formula's nodes to the tape and returns the node of its result in `result`, or what is
/// wrong: unknown names and characters all at once, else the first mistake in grammar. Powers bind
/// to the right and before signs (-2^2 is -4), then * and /, then + and -.
std::vector<FormulaError> parse_formula(const std::string& text, const ArgumentNames& names,
                                        Tape& tape, Tape::Index& result);

}  // namespace ilss
