#include "sensors/lep/head_motion.h"

#include <algorithm>
#include <cmath>

namespace ilss {

HeadMotion::HeadMotion(const HeadDrive& drive, double angle)
    : drive_(drive), turns_{{0, angle, angle, 0}} {}

double HeadMotion::angle(double time) const {
  auto turn = turns_.end() - 1;
  while (turn != turns_.begin() && turn->start > time) --turn;
  const double turned = turn->rate * std::max(0.0, time - turn->start);
  return std::abs(turned) < std::abs(turn->to - turn->from) ? turn->from + turned : turn->to;
}

void HeadMotion::begin(double time, double to, double rate) {
  const double from = angle(time);
  while (!turns_.empty() && turns_.back().start >= time) turns_.pop_back();
  turns_.push_back({time, from, to, rate});
}

void HeadMotion::turn_to(double angle, double time) {
  double to = std::round(angle / drive_.step) * drive_.step;
  constexpr double rounding = 1e-9;  // rad
  if (std::abs(to) > drive_.stop + rounding) to -= std::copysign(drive_.step, to);
  begin(time, to, std::copysign(drive_.fastest, to - this->angle(time)));
}

void HeadMotion::turn_at(double rate, double time) {
  begin(time, rate == 0 ? angle(time) : std::copysign(drive_.stop, rate), rate);
}

void HeadMotion::forget_before(double time) {
  const auto later = std::find_if(turns_.begin() + 1, turns_.end(),
                                  [&](const Turn& turn) { return turn.start > time; });
  turns_.erase(turns_.begin(), later - 1);
}

}  // namespace ilss
