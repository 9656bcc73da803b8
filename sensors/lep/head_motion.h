// How the LEP sensor's head turns: to an angle, or at a rate, between its stops.
#pragma once

#include <vector>

namespace ilss {

/// The servo's limits (Pears 1997, table 1): steps of 0.36 degrees, 90 degrees in 0.5 s, ±90
/// degrees.
struct HeadDrive {
  double step = 0.0062831853071795865;  ///< 0.36 degrees (rad)
  double fastest = 3.1415926535897932;  ///< rad/s
  double stop = 1.5707963267948966;     ///< rad, to either side
};

/// The head's angle over time, positive to the left (rad): at a constant rate after each command,
/// until it gets to its target. It is known exactly, since the drive is a geared stepper motor
/// (Pears 1997, sec. 4.2).
class HeadMotion {
 public:
  HeadMotion(const HeadDrive& drive, double angle);

  double angle(double time) const;

  /// From `time` (s) on, turns at the fastest rate to the step nearest to `angle` that is not
  /// beyond a stop. How it turned before that time stays as it was.
  void turn_to(double angle, double time);
  /// From `time` (s) on, turns at `rate` (rad/s) until a stop.
  void turn_at(double rate, double time);
  /// Forgets how it turned before `time` (s).
  void forget_before(double time);

 private:
  struct Turn {
    double start;
    double from;
    double to;
    double rate;
  };
  void begin(double time, double to, double rate);

  HeadDrive drive_;
  std::vector<Turn> turns_;  ///< by start, never empty
};

}  // namespace ilss
