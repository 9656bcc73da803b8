// Network expressions: how modules are put together by serial and combine.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "framework/module/document.h"

namespace ilss {

/// A module's name, or an operator over expressions.
struct Expression {
  enum class Kind { name, serial, combine };

  Kind kind = Kind::name;
  Position position = {};
  std::string name = {};               ///< of a module
  std::vector<Expression> parts = {};  ///< of an operator, in order
  std::optional<double> max_age = {};  ///< of combine: older held values are the fault stale (s)
};

/// Reads an expression; what is wrong goes to `diagnostics` and its part is left out.
Expression read_expression(const Node& node, Diagnostics& diagnostics);

}  // namespace ilss
