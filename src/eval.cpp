#include "src/session.h"

namespace ilss {

void add_eval(CLI::App& app, Session& session) { (void)app, (void)session; }

}  // namespace ilss
