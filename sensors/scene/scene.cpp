#include "sensors/scene/scene.h"

#include <cmath>

namespace ilss {

void ScenePoint::declare(OptionVisitor& visit) {
  visit("x", x, "forward of the world's origin", {.unit = "m"});
  visit("z", z, "to the right of the world's origin", {.unit = "m"});
}

void WallTarget::declare(OptionVisitor& visit) {
  visit("along", along, "where the first stripe is centred, from the wall's first end",
        {.unit = "m"});
  visit("height", height, "of the horizontal line's centre above the optical axis", {.unit = "m"});
  visit("line_thickness", line_thickness, "of the horizontal line", {.unit = "m", .minimum = 0});
  visit("line_length", line_length, "of the horizontal line, centred on the stripes",
        {.unit = "m", .minimum = 0});
  visit("stripe_count", stripe_count, "number of vertical stripes",
        {.minimum = 0, .maximum = 1000});
  visit("stripe_spacing", stripe_spacing, "from centre to centre", {.unit = "m", .minimum = 0});
  visit("stripe_width", stripe_width, "of each stripe", {.unit = "m", .minimum = 0});
  visit("stripe_bottom", stripe_bottom, "lower end of the stripes", {.unit = "m"});
  visit("stripe_top", stripe_top, "upper end of the stripes", {.unit = "m"});
  visit("reflectivity", reflectivity, "of line and stripes", {.minimum = 0, .maximum = 1});
}

void Wall::declare(OptionVisitor& visit) {
  visit("from", from, "the wall's first end", {.required = true});
  visit("to", to, "the wall's other end", {.required = true});
  visit("reflectivity", reflectivity, "share of the light that comes back",
        {.minimum = 0, .maximum = 1});
  visit("targets", targets, "camera targets on the wall");
  visit.require(std::hypot(to.x - from.x, to.z - from.z) > 0, "a wall needs two different ends");
}

void Pillar::declare(OptionVisitor& visit) {
  visit("centre", centre, "its middle", {.required = true});
  visit("radius", radius, "of its surface", {.unit = "m", .required = true, .minimum = 0});
  visit("reflectivity", reflectivity, "share of the light that comes back",
        {.minimum = 0, .maximum = 1});
  visit.require(radius > 0, "a pillar's radius must be above 0");
}

void Scene::declare(OptionVisitor& visit) {
  visit("scene", description, "what the scene shows");
  visit("walls", walls, "the walls", {.required = true});
  visit("pillars", pillars, "round pillars");
}

ScenePose compose_poses(const ScenePose& base, const ScenePose& mount) {
  const double c = std::cos(base.heading);
  const double s = std::sin(base.heading);
  return {base.x + c * mount.x - s * mount.z, base.z + s * mount.x + c * mount.z,
          base.heading + mount.heading};
}

ScenePose drive(const ScenePose& pose, double speed, double turn_rate, double time) {
  const double turned = turn_rate * time;
  // Along a circle, or along its chord where it hardly turns.
  const double chord =
      std::abs(turned) < 1e-6 ? speed * time : 2 * speed / turn_rate * std::sin(turned / 2);
  const double towards = pose.heading + turned / 2;
  return {pose.x + chord * std::cos(towards), pose.z + chord * std::sin(towards),
          pose.heading + turned};
}

ScenePoint to_frame(const ScenePose& pose, const ScenePoint& point) {
  const double c = std::cos(pose.heading);
  const double s = std::sin(pose.heading);
  const double dx = point.x - pose.x;
  const double dz = point.z - pose.z;
  return {c * dx + s * dz, -s * dx + c * dz};
}

}  // namespace ilss
