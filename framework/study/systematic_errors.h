// Wrong constants in a simulation: what a system gives when its persistent errors are drawn.
#pragma once

#include "framework/graph/system.h"

namespace ilss {

/// A simulated system's constants are also the simulation's truth, so that errors of constants
/// never show by themselves. Here they are drawn: every persistent source gets an error of its law,
/// the outputs of sensors and estimators move by G e (first order, as their lineage states), and
/// the functions behind them are evaluated again with their own constants moved alike. Sets
/// `output` to the system's first output, as it stands after a tick, under the errors that follow
/// from `seed`; its lineage is the one stated there. A fault where a function gives one there.
Outcome<> draw_systematic_errors(const System& system, std::uint64_t seed, Estimate& output);

}  // namespace ilss
