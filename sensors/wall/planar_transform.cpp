#include "sensors/wall/planar_transform.h"

namespace ilss {

void PlanarTransform::Options::declare(OptionVisitor& visit) {
  visit("from", from, "name of the input's frame");
  visit("to", to, "name of the output's frame");
  visit("axes", axes, "the input frame's axes: camera is x right, z forward; robot the reverse");
  visit.require(from != to, "'from' and 'to' name the same frame");
}

void PlanarTransform::set_frames(Interface& interface, const Options& options) {
  interface.inputs[0].frame = options.from;
  interface.frame = options.to;
  interface.frame_of_input.reset();
}

}  // namespace ilss
