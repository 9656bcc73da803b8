// A plan as a picture: the network in Graphviz's DOT language.
#pragma once

#include <string>

#include "framework/graph/plan.h"

namespace ilss {

/// The plan as a DOT digraph: modules as boxes with name and type, coloured by kind; nested systems
/// as frames around theirs; connections labelled with payload and frame; an arrow out of the
/// picture for each output; a dashed one from what drives a command to the module that follows it.
/// The same plan gives the same text.
std::string to_dot(const Plan& plan);

}  // namespace ilss
