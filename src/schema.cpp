// `ilss schema`: the JSON Schema of graph files.
#include "framework/graph/schema.h"

#include <fmt/format.h>

#include "src/session.h"

namespace ilss {

void add_schema(Verb command, Session& session) {
  Verb verb = command.add_verb("schema", "Print the JSON Schema of graph files, for editors");
  const auto json = std::make_shared<bool>(false);
  verb.add_flag("--json", *json, "The schema is JSON in any case");
  verb.on_call([json, &session] {
    session.load_modules();
    fmt::print("{}\n", graph_schema(session.registry));
  });
}

}  // namespace ilss
