#include "tests/framework/graph/test_modules.h"

namespace ilss::test {

const Registry& registry() {
  static const Registry* const all = [] {
    auto* made = new Registry;
    made->add<Reading>();
    made->add<PairReading>();
    made->add<TurnReading>();
    made->add<Total>();
    made->add<Add>();
    made->add<Subtract>();
    made->add<Product>();
    made->add<Sine>();
    made->add<Root>();
    made->add<Magnitude>();
    made->add<Gain>();
    made->add<Join>();
    made->add<Mix>();
    made->add<Collapse>();
    made->add<Carry>();
    made->add<Head>();
    return made;
  }();
  return *all;
}

}  // namespace ilss::test
