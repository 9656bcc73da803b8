// Where one surface ends in a scan and another begins: the adaptive breakpoint detector.
#pragma once

#include <array>
#include <string_view>

#include "framework/module/module_type.h"
#include "sensors/laser/segment/segmented_scan.h"

namespace ilss {

/// How far apart two neighbouring readings of one surface may be.
class BreakpointRule {
 public:
  /// `incidence`: lambda (rad); `noise`: how far apart noise alone may bring them (m).
  BreakpointRule(double incidence, double noise) : incidence_(incidence), noise_(noise) {}

  /// Whether the surface ends between a reading and the next one, `step` (rad) farther on.
  bool breaks(double range_before, double range, double step);
  /// Whether three beams one after another are, by a quick look, readings of one surface: if so,
  /// `breaks` says that it does not end between them. They are at the last step from each other.
  bool continues(const LaserBeam& a, const LaserBeam& b, const LaserBeam& c) const;

 private:
  double incidence_;
  double noise_;
  double step_ = 0;       ///< the last one's, for which these hold:
  double tolerance_ = 0;  ///< of steps that pass for it
  double reach_ = 0;      ///< sin(step) / sin(lambda - step), infinite from lambda on
  double cosine_ = 1;
};

/// Estimator: takes a laser_scan apart into clusters. A cluster ends at a rupture point, which is a
/// beam without return, and at a breakpoint: between readings n-1 and n whose points are farther
/// apart than
///   r_{n-1} sin(dphi) / sin(lambda - dphi) + deviations · sigma,
/// the distance on a surface that the beam meets at the angle lambda, and the noise
/// (sigma² = range_std² + quantum²/12). Published with 3 sigma, of which the difference of two
/// ranges often has more, so that dense or noisy scans of one surface break; here it is three
/// standard deviations of the difference, 3 sqrt(2) sigma. Steps dphi of
/// lambda and more never break. Clusters of fewer than `least_readings` are isolated readings and
/// belong to none. Input: a laser_scan; output: a segmented_scan in its frame, whose segments are
/// the clusters. Faults: bad_data where a number is not finite or a range negative; no_detection
/// where no cluster is left.
class Breakpoints final : public Module {
 public:
  static constexpr std::string_view name = "breakpoints";
  static constexpr std::string_view description =
      "takes a laser's scan apart where it jumps: the adaptive breakpoint detector";
  static constexpr std::string_view reference =
      "Borges & Aldon 2004, as in Núñez et al. 2009, sec. 3.1";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr std::array faults = {FaultKind::bad_data, FaultKind::no_detection};

  struct Options {
    double incidence = 0.17453292519943295;
    double deviations = 4.2426406871192851;
    std::int64_t least_readings = 3;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();

  explicit Breakpoints(const Options& options) : options_(options) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;

 private:
  Options options_;
};

}  // namespace ilss
