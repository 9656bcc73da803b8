// Network expressions: how modules are put together by serial and combine.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "framework/module/document.h"
#include "framework/module/time.h"

namespace ilss {

/// A module's name, or an operator over expressions.
struct Expression {
  /// `unread`: an operator that is not known; its parts are what could be made out.
  enum class Kind { name, serial, combine, unread };

  Kind kind = Kind::name;
  Position position = {};
  std::string name = {};                 ///< of a module
  std::vector<Expression> parts = {};    ///< of an operator, in order
  std::optional<Duration> max_age = {};  ///< of combine: older held values are the fault stale
  bool hides_names = false;              ///< names of modules may stand in what could not be read
};

/// Reads an expression; what is wrong goes to `diagnostics` and becomes `unread`.
Expression read_expression(const Node& node, Diagnostics& diagnostics);

}  // namespace ilss
