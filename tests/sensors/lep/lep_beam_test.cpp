// The LEP's beam in a scene: image positions, currents, mixed images and missing parts.
#include "sensors/lep/lep_beam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>

namespace ilss {
namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr LepGeometry<double> geometry;

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Wall wall(ScenePoint from, ScenePoint to, double reflectivity = 1) {
  return {from, to, reflectivity, {}};
}

Scene scene_of(std::vector<Wall> walls, std::vector<Pillar> pillars = {}) {
  Scene scene;
  scene.walls = std::move(walls);
  scene.pillars = std::move(pillars);
  return scene;
}

LepImage cast(const Scene& scene, const LepBeam& beam, double scan_angle = 0,
              const ScenePose& projection = {}) {
  return LepBeamCaster(geometry, beam).cast(scene, projection, scan_angle);
}

constexpr LepBeam one_ray{.rays = 1};

TEST(LepBeam, ItsCentreRayGivesTheImageOfTheGeometry) {
  constexpr unsigned seed = 51;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  for (int run = 0; run < 2000; ++run) {
    const ScenePose projection{uniform(random, -2, 2), uniform(random, -2, 2),
                               uniform(random, -4, 4)};
    const double theta = uniform(random, -20, 20) * degree;
    const double range = uniform(random, 0.4, 2.5);
    const double heading = projection.heading + theta;
    const ScenePoint lit{projection.x + range * std::cos(heading),
                         projection.z + range * std::sin(heading)};
    const double along = heading + std::numbers::pi / 2 + uniform(random, -50, 50) * degree;
    const Scene scene =
        scene_of({wall({lit.x - std::cos(along), lit.z - std::sin(along)},
                       {lit.x + 2 * std::cos(along), lit.z + 2 * std::sin(along)}, 0.7)});
    const LepImage image = cast(scene, one_ray, theta, projection);
    ASSERT_NEAR(image.image_position, LepRay<double>(geometry, theta).image_position(1 / range),
                1e-13)
        << "run " << run;
    ASSERT_NEAR(image.current * range * range / (0.7 * one_ray.current_at_1m), 1, 1e-12);
  }
}

TEST(LepBeam, HasGaussianRaysOfTwoStandardDeviationsEachSide) {
  const LepBeam beam;
  double sum = 0;
  for (int i = 0; i < 9; ++i) sum += std::exp(-2 * std::pow((i - 4) / 4.0, 2));
  double share = 0;
  for (int i = 0; i < 9; ++i) {
    const double offset = (i - 4) / 4.0 * 0.0015;
    share += std::exp(-2 * std::pow((i - 4) / 4.0, 2)) / sum;
    // A wall that ends to the right of ray i takes the rays up to it.
    const Scene scene = scene_of({wall({100, -9}, {100, offset + 1e-4})});
    EXPECT_NEAR(cast(scene, beam).current * 1e4 / beam.current_at_1m, share, 1e-9) << "ray " << i;
  }
}

TEST(LepBeam, BringsBackACurrentThatFallsWithTheSquareOfTheRange) {
  for (const double range : {0.5, 1.0, 2.0})
    EXPECT_NEAR(cast(scene_of({wall({range, -9}, {range, 9}, 0.5)}), one_ray).current,
                0.5 * 25.8e-9 / (range * range), 1e-20);
}

TEST(LepBeam, BringsBackNothingFromAnEmptySceneOrABlackWall) {
  EXPECT_EQ(cast({}, {}).current, 0);
  EXPECT_EQ(cast(scene_of({wall({-1, -9}, {-1, 9})}), {}).current, 0) << "a wall behind it";
  EXPECT_EQ(cast(scene_of({wall({1, -9}, {1, 9}, 0)}), {}).current, 0);
}

TEST(LepBeam, MixesTheImagesOfTwoSurfacesAtAStep) {
  const double near = cast(scene_of({wall({1, -9}, {1, 9})}), {}).image_position;
  const double behind = cast(scene_of({wall({1.2, -9}, {1.2, 9})}), {}).image_position;
  ASSERT_GT(near, behind);
  // The nearer surface ends to the left of the beam's middle: the lens, to the right, sees both.
  double last = near;
  for (const double edge : {0.0014, 0.0009, 0.0004, -0.0002, -0.0006, -0.0010, -0.0014}) {
    const LepImage mixed =
        cast(scene_of({wall({1, -9}, {1, edge}), wall({1.2, -9}, {1.2, 9})}), {});
    EXPECT_LT(mixed.image_position, last);
    EXPECT_GT(mixed.image_position, behind);
    last = mixed.image_position;
  }
}

TEST(LepBeam, MissesWhatASecondWallHidesFromTheLens) {
  const Wall lit = wall({1, -9}, {1, 9});
  // The line of sight from (1, 0) to the lens, 8 to 9 cm to the right, passes z = 0.04 at x = 0.5.
  EXPECT_GT(cast(scene_of({lit}), {}).current, 0);
  EXPECT_EQ(cast(scene_of({lit, wall({0.5, 0.01}, {0.5, 0.3})}), {}).current, 0);
  EXPECT_GT(cast(scene_of({lit, wall({0.5, 0.2}, {0.5, 0.3})}), {}).current, 0);
  EXPECT_GT(cast(scene_of({lit, wall({0.5, -0.3}, {0.5, -0.01})}), {}).current, 0)
      << "on the side where no lens is";
  EXPECT_GT(cast(scene_of({lit, wall({1.1, 0.01}, {1.1, 0.3})}), {}).current, 0) << "behind it";
}

TEST(LepBeam, MissesAWallThatTurnsItsBackToTheLens) {
  // Steep walls through (1, 0): the laser sees one side; the lens is 5 degrees farther round.
  const auto through = [](double angle) {
    const double c = 0.5 * std::cos(angle * degree);
    const double s = 0.5 * std::sin(angle * degree);
    return scene_of({wall({1 - c, -s}, {1 + c, s})});
  };
  EXPECT_GT(cast(through(20), one_ray).current, 0);
  EXPECT_EQ(cast(through(-2), one_ray).current, 0) << "it rises between laser and lens";
  EXPECT_GT(cast(through(-20), one_ray).current, 0) << "beyond the lens: both see the same side";
}

TEST(LepBeam, MissesTheFarSideOfAPillar) {
  // The pillar's right flank looks to the lens, the left flank does not where it is steep.
  const auto pillar_beside = [](double across) {
    return cast(scene_of({}, {{{1, across}, 0.1, 1}}), one_ray).current;
  };
  EXPECT_GT(pillar_beside(0), 0);
  EXPECT_GT(pillar_beside(-0.0999), 0) << "the ray grazes its right flank";
  EXPECT_EQ(pillar_beside(0.0999), 0) << "the ray grazes its left flank";
}

TEST(LepBeam, MissesWhatAPillarHidesFromTheLens) {
  const Wall lit = wall({1, -9}, {1, 9});
  EXPECT_EQ(cast(scene_of({lit}, {{{0.5, 0.04}, 0.02, 1}}), one_ray).current, 0);
  EXPECT_GT(cast(scene_of({lit}, {{{0.5, -0.04}, 0.02, 1}}), one_ray).current, 0);
}

/// An independent account of one ray, in world axes: where it ends and whether the lens sees that.
class WorldRay {
 public:
  WorldRay(const Scene& scene, const ScenePose& projection, double scan_angle, double offset)
      : scene_(scene) {
    const double heading = projection.heading + scan_angle;
    direction_ = {std::cos(heading), std::sin(heading)};
    const ScenePoint right{-direction_.z, direction_.x};
    laser_ = {projection.x, projection.z};
    start_ = {laser_.x + offset * right.x, laser_.z + offset * right.z};
    const double optical = heading - geometry.vergence;
    axis_ = {std::cos(optical), std::sin(optical)};
    lens_ = {laser_.x - geometry.baseline * std::sin(projection.heading) -
                 geometry.lens_distance * axis_.x,
             laser_.z + geometry.baseline * std::cos(projection.heading) -
                 geometry.lens_distance * axis_.z};
    find_end();
  }

  /// Whether laser or lens are inside a pillar, which says nothing of a sensor.
  bool stands_in_pillar() const {
    for (const Pillar& pillar : scene_.pillars)
      for (const ScenePoint& point : {start_, lens_}) {
        const ScenePoint to = minus(pillar.centre, point);
        if (dot(to, to) <= pillar.radius * pillar.radius) return true;
      }
    return false;
  }

  /// How near to a decision that rounding could turn.
  double margin() const { return margin_; }

  /// Current (for unit weight) and image position, if the lens sees the end.
  std::optional<LepImage> image() {
    if (!(range_ < 1e9) || hidden()) return std::nullopt;
    const ScenePoint seen = minus(end_, lens_);
    const double depth = dot(axis_, seen);
    note(std::abs(depth));
    if (depth <= 0) return std::nullopt;
    const ScenePoint from_laser = minus(end_, laser_);
    return LepImage{reflectivity_ / dot(from_laser, from_laser),
                    -geometry.focal_length * cross(axis_, seen) / depth};
  }

 private:
  static ScenePoint minus(const ScenePoint& a, const ScenePoint& b) {
    return {a.x - b.x, a.z - b.z};
  }
  static double dot(const ScenePoint& a, const ScenePoint& b) { return a.x * b.x + a.z * b.z; }
  static double cross(const ScenePoint& a, const ScenePoint& b) { return a.x * b.z - a.z * b.x; }
  void note(double distance) { margin_ = std::min(margin_, distance); }

  /// Solves p + t d = a + s (b - a) for t and s.
  static std::pair<double, double> crossing(const ScenePoint& p, const ScenePoint& d,
                                            const Wall& w) {
    const ScenePoint e = minus(w.to, w.from);
    const ScenePoint f = minus(w.from, p);
    const double determinant = cross(d, e);
    return {cross(f, e) / determinant, cross(f, d) / determinant};
  }

  void find_end() {
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const auto [t, s] = crossing(start_, direction_, scene_.walls[i]);
      note(std::min({std::abs(t), std::abs(s), std::abs(s - 1)}));
      if (t > 0 && s >= 0 && s <= 1) end_at(t, scene_.walls[i].reflectivity, i);
    }
    for (std::size_t i = 0; i < scene_.pillars.size(); ++i) {
      const Pillar& pillar = scene_.pillars[i];
      const ScenePoint to = minus(pillar.centre, start_);
      const double across = std::abs(cross(direction_, to));
      note(std::abs(across - pillar.radius));
      if (across >= pillar.radius) continue;
      const double t =
          dot(direction_, to) - std::sqrt(pillar.radius * pillar.radius - across * across);
      note(std::abs(t));
      if (t > 0) end_at(t, pillar.reflectivity, scene_.walls.size() + i);
    }
  }

  void end_at(double t, double reflectivity, std::size_t surface) {
    note(std::abs(t - range_));
    if (t >= range_) return;
    range_ = t;
    reflectivity_ = reflectivity;
    surface_ = surface;
    end_ = {start_.x + t * direction_.x, start_.z + t * direction_.z};
  }

  bool hidden() {
    const ScenePoint sight = minus(lens_, end_);
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const Wall& w = scene_.walls[i];
      if (i == surface_) {
        const ScenePoint e = minus(w.to, w.from);
        const double of_lens = cross(e, minus(lens_, w.from));
        note(std::abs(of_lens));
        if (of_lens * -cross(e, direction_) < 0) return true;
        continue;
      }
      const auto [t, s] = crossing(end_, sight, w);
      note(std::min({std::abs(t), std::abs(t - 1), std::abs(s), std::abs(s - 1)}));
      if (t > 0 && t < 1 && s > 0 && s < 1) return true;
    }
    for (const Pillar& pillar : scene_.pillars) {
      // The point of the sight nearest to the centre; the lit pillar's own surface is not inside.
      const ScenePoint to = minus(pillar.centre, end_);
      const double t = std::clamp(dot(to, sight) / dot(sight, sight), 0.0, 1.0);
      const ScenePoint nearest{end_.x + t * sight.x, end_.z + t * sight.z};
      const ScenePoint off = minus(pillar.centre, nearest);
      const double inside = pillar.radius - std::sqrt(dot(off, off));
      const bool own =
          scene_.walls.size() + static_cast<std::size_t>(&pillar - scene_.pillars.data()) ==
          surface_;
      if (!own) note(std::abs(inside));
      if (inside > (own ? 1e-9 : 0)) return true;
    }
    return false;
  }

  const Scene& scene_;
  ScenePoint direction_, axis_, laser_, lens_, start_, end_;
  double range_ = INFINITY;
  double reflectivity_ = 0;
  std::size_t surface_ = 0;
  double margin_ = INFINITY;
};

Scene random_scene(std::mt19937_64& random) {
  Scene scene;
  for (int i = 0; i < 5; ++i) {
    const ScenePoint from{uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5)};
    scene.walls.push_back(wall(
        from, {from.x + uniform(random, -1.5, 1.5), from.z + uniform(random, -1.5, 1.5)}, 0.6));
  }
  for (int i = 0; i < 2; ++i)
    scene.pillars.push_back({{uniform(random, -1.5, 1.5), uniform(random, -1.5, 1.5)},
                             uniform(random, 0.02, 0.3),
                             0.9});
  return scene;
}

TEST(LepBeam, AgreesWithRaysCastInWorldAxesOverRandomScenes) {
  constexpr unsigned seed = 52;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  int seen = 0;
  int missing = 0;
  int partly = 0;
  const LepBeam beam{.width = 0.1};
  for (int run = 0; run < 4000; ++run) {
    const Scene scene = random_scene(random);
    const ScenePose projection{uniform(random, -1, 1), uniform(random, -1, 1),
                               uniform(random, -4, 4)};
    const double theta = uniform(random, -20, 20) * degree;
    double margin = INFINITY;
    double current = 0;
    double moment = 0;
    double weights = 0;
    int rays = 0;
    for (int i = 0; i < 9; ++i) {
      const double place = (i - 4) / 4.0;
      const double weight = std::exp(-2 * place * place);
      weights += weight;
      WorldRay ray(scene, projection, theta, place * beam.width / 2);
      const auto image = ray.image();
      margin = ray.stands_in_pillar() ? 0 : std::min(margin, ray.margin());
      if (!image) continue;
      ++rays;
      current += weight * image->current;
      moment += weight * image->current * image->image_position;
    }
    if (margin < 1e-9) continue;
    const LepImage image = cast(scene, beam, theta, projection);
    if (rays == 0) {
      ++missing;
      EXPECT_EQ(image.current, 0) << "run " << run;
      continue;
    }
    (rays == 9 ? seen : partly) += 1;
    EXPECT_NEAR(image.current / (beam.current_at_1m * current / weights), 1, 1e-9) << "run " << run;
    EXPECT_NEAR(image.image_position / (moment / current), 1, 1e-7) << "run " << run;
  }
  EXPECT_GT(seen, 300);
  EXPECT_GT(missing, 300);
  EXPECT_GT(partly, 300);
}

}  // namespace
}  // namespace ilss
