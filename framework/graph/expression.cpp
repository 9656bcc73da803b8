#include "framework/graph/expression.h"

#include <fmt/format.h>

#include "framework/estimate/units.h"

namespace ilss {
namespace {

void read_parts(const Node& list, Expression& expression, Diagnostics& diagnostics) {
  if (!list.is_list() || list.size() == 0) {
    diagnostics.add(list.position,
                    "expected a list of modules or expressions, got " +
                        (list.is_list() ? std::string("an empty list") : list.description()));
    expression.kind = Expression::Kind::unread;
    expression.hides_names = list.is_map();
    return;
  }
  for (const Node& part : list.values) {
    expression.parts.push_back(read_expression(part, diagnostics));
    expression.hides_names |= expression.parts.back().hides_names;
  }
}

/// `combine: {of: [...], align: latest, max_age: 20 ms}`
void read_combine_map(const Node& map, Expression& expression, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Node& key = map.keys[i];
    const Node& value = map.values[i];
    if (key.text == "of") {
      read_parts(value, expression, diagnostics);
    } else if (key.text == "align") {
      if (value.is_scalar() && value.text == "interpolate")
        diagnostics.add(value.position, "align: interpolate is not available; use latest");
      else if (!value.is_scalar() || value.text != "latest")
        diagnostics.add(value.position, "expected latest, got " + value.description());
    } else if (key.text == "max_age") {
      const auto age = parse_quantity(value.text, "s");
      if (!value.is_scalar() || std::holds_alternative<std::string>(age))
        diagnostics.add(value.position, value.is_scalar()
                                            ? std::get<std::string>(age)
                                            : "expected a time (s), got " + value.description());
      else if (std::get<double>(age) < 0)
        diagnostics.add(value.position, "a time cannot be negative");
      else
        expression.max_age = duration_of(std::get<double>(age));
    } else {
      diagnostics.add(key.position, fmt::format("combine has no key '{}'{}", key.text,
                                                suggestion(key.text, {"of", "align", "max_age"})));
    }
  }
  if (map.find("of") != nullptr) return;
  diagnostics.add(map.position, "combine needs a list, or a map with the key 'of'");
  expression.kind = Expression::Kind::unread;
  expression.hides_names = true;
}

}  // namespace

Expression read_expression(const Node& node, Diagnostics& diagnostics) {
  Expression expression;
  expression.position = node.position;
  if (node.is_scalar()) {
    expression.name = node.text;
    return expression;
  }
  if (!node.is_map() || node.size() != 1) {
    diagnostics.add(node.position,
                    fmt::format("expected a module's name, serial: [...] or "
                                "combine: [...], got {}",
                                node.is_map() ? "a map of other keys" : node.description()));
    expression.kind = Expression::Kind::unread;
    expression.hides_names = true;
    return expression;
  }
  const std::string& op = node.keys.front().text;
  const Node& value = node.values.front();
  if (op == "serial") {
    expression.kind = Expression::Kind::serial;
    read_parts(value, expression, diagnostics);
  } else if (op == "combine") {
    expression.kind = Expression::Kind::combine;
    if (value.is_map())
      read_combine_map(value, expression, diagnostics);
    else
      read_parts(value, expression, diagnostics);
  } else {
    diagnostics.add(node.keys.front().position,
                    op == "select" ? std::string("select is not available in this version")
                                   : fmt::format("unknown operator '{}'{}", op,
                                                 suggestion(op, {"serial", "combine"})));
    if (value.is_list()) read_parts(value, expression, diagnostics);
    expression.kind = Expression::Kind::unread;
    expression.hides_names |= value.is_map();
  }
  return expression;
}

}  // namespace ilss
