#include "sensors/laser/laser_mount.h"

#include <algorithm>
#include <array>

namespace ilss {

void set_mount(const Estimate& parameters, std::size_t first_parameter, Estimate& scan) {
  for (std::size_t i = 0; i < mount_size; ++i)
    scan.value[first_mount + i] = parameters.value[first_parameter + i];
  std::array<double, dimension_of<LaserScan>> sensitivity{};
  for (std::size_t k = 0; k < parameters.lineage.size(); ++k) {
    const auto mount = parameters.lineage.column(k).subspan(first_parameter, mount_size);
    if (std::ranges::all_of(mount, [](double s) { return s == 0; })) continue;
    std::ranges::copy(mount, sensitivity.begin() + first_mount);
    scan.lineage.add(parameters.lineage.sources()[k], sensitivity);
  }
}

}  // namespace ilss
