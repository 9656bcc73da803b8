#include "src/session.h"

namespace ilss {

void add_check(CLI::App& app, Session& session) { (void)app, (void)session; }

}  // namespace ilss
