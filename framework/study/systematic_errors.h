// Wrong constants in a simulation: what a system gives when its persistent errors are drawn.
#pragma once

#include <random>

#include "framework/graph/system.h"

namespace ilss {

/// A simulated system's constants are also the simulation's truth, so that errors of constants
/// never show by themselves. Here they are drawn: every persistent source of one run gets an error
/// e of unit variance, the outputs of sensors and estimators move by G e (first order, as their
/// lineage states), and the functions behind them are evaluated again with their own constants
/// moved alike.
class SystematicErrors {
 public:
  /// `system` must outlive this.
  explicit SystematicErrors(const System& system);

  /// The system's output (the first of its outputs) as it stands after a tick, under the errors
  /// that follow from `seed`. A fault where a function gives one there.
  Outcome<> apply(std::uint64_t seed, Estimate& output);

 private:
  struct Node {
    bool needed = false;
    Output output = {};
    Estimate parameters = {};
    std::vector<const Output*> inputs = {};
  };

  const System& system_;
  std::vector<Node> nodes_;
};

}  // namespace ilss
