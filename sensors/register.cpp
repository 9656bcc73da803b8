#include "sensors/register.h"

namespace ilss {

void register_sensors(Registry& registry) { (void)registry; }

}  // namespace ilss
