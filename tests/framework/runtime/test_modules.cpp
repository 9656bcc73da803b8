#include "tests/framework/runtime/test_modules.h"

namespace ilss::runtime_test {

const Registry& registry() {
  static const Registry result = [] {
    Registry modules;
    modules.add<Counter>();
    modules.add<Thrower>();
    modules.add<Dial>();
    modules.add<Increment>();
    modules.add<Subtract>();
    modules.add<Sum>();
    modules.add<Switch>();
    modules.add<Archive>();
    return modules;
  }();
  return result;
}

Plan plan_of(const std::string& text) {
  Diagnostics diagnostics;
  const Node graph = parse_document(text, "test.yaml", diagnostics);
  auto plan = build_plan(graph, ".", registry(), {}, diagnostics);
  for (const Diagnostic& diagnostic : diagnostics.sorted())
    ADD_FAILURE() << format_diagnostic(diagnostic);
  return plan.value_or(Plan{});
}

}  // namespace ilss::runtime_test
