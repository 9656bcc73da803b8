// Says what an angle is in radians, by ilss.
#include <iostream>

#include "framework/estimate/units.h"

int main() { std::cout << std::get<double>(ilss::parse_quantity("180 deg", "rad")) << '\n'; }
