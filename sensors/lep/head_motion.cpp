#include "sensors/lep/head_motion.h"

#include <algorithm>
#include <cmath>

namespace ilss {

HeadMotion::HeadMotion(const HeadDrive& drive, double angle)
    : drive_(drive), from_(angle), to_(angle) {}

double HeadMotion::angle(double time) const {
  const double turned = rate_ * std::max(0.0, time - start_);
  const double left = to_ - from_;
  return std::abs(turned) < std::abs(left) ? from_ + turned : to_;
}

void HeadMotion::turn_to(double angle, double time) {
  from_ = this->angle(time);
  start_ = time;
  to_ = std::round(angle / drive_.step) * drive_.step;
  rate_ = std::copysign(drive_.fastest, to_ - from_);
}

void HeadMotion::turn_at(double rate, double time) {
  from_ = angle(time);
  start_ = time;
  rate_ = rate;
  to_ = rate == 0 ? from_ : std::copysign(drive_.stop, rate);
}

}  // namespace ilss
