#include "sensors/laser/simulate/laser_scene.h"

namespace ilss {

void LaserScene::Options::declare(OptionVisitor& visit) {
  world.declare(visit);
  visit("frame", frame, "name of the laser's frame, x forward and y to the left");
}

Interface LaserScene::interface(const Options& options) {
  return {.inputs = {},
          .output = &descriptor<LaserScan>(),
          .frame = options.frame,
          .draws_readings = true};
}

Outcome<> LaserScene::scan(const Evaluation& evaluation, bool noisy, Output& output) {
  const Outcome<LaserStand> stand = world_.enter(evaluation);
  if (!stand) return stand.fault();
  stand_ = *stand;
  world_.scan(evaluation, *stand, noisy, make_beams(output, world_.sweep().beams));
  world_.describe(evaluation, output.estimate);
  output.acquired = {evaluation.time - duration_of(world_.sweep().duration), evaluation.time};
  return {};
}

Outcome<> LaserScene::evaluate(const Evaluation& evaluation, Output& output) {
  return scan(evaluation, true, output);
}

Outcome<> LaserScene::expect(const Evaluation& evaluation, const Output* operating_point,
                             Output& output) {
  if (operating_point != nullptr)
    return Fault{FaultKind::no_error_known,
                 "a scan cannot be given as an operating point; it follows from the scene"};
  return scan(evaluation, false, output);
}

}  // namespace ilss
