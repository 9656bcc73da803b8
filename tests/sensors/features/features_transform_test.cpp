// Features in another frame: where they are, their derivatives, and what they share.
#include "sensors/features/features_transform.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/allocation_count.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

constexpr double pi = std::numbers::pi;

/// A feature with three errors of `owner`, each of all components but the counts.
Estimate feature_of(const PayloadDescriptor& type, const std::vector<double>& value,
                    std::mt19937_64& draw, std::uint32_t owner = 50) {
  Estimate feature(type, "robot");
  feature.value = value;
  std::normal_distribution<double> normal(0, 0.01);
  for (std::uint32_t k = 0; k < 3; ++k) {
    std::vector<double> column(type.dimension(), 0.0);
    for (std::size_t i = 0; i < column.size(); ++i)
      if (type.components[i].unit != "1") column[i] = normal(draw);
    feature.lineage.add({owner, k, 0}, column);
  }
  return feature;
}

/// A line segment between two points; rho is not negative.
std::vector<double> line_through(double ax, double az, double bx, double bz) {
  double phi = std::atan2(bx - ax, -(bz - az));
  double rho = ax * std::cos(phi) + az * std::sin(phi);
  if (rho < 0) {
    rho = -rho;
    phi = wrap_angle(phi + pi);
  }
  return {rho, phi, ax, az, bx, bz, 20, 3, 25};
}

/// One of each: a segment, its edge, an arc and a corner.
std::vector<Estimate> random_features(std::mt19937_64& draw) {
  std::uniform_real_distribution<double> at(-4, 4);
  const auto line = line_through(at(draw), at(draw), at(draw), at(draw));
  std::vector<Estimate> features;
  features.push_back(feature_of(descriptor<LineSegment>(), line, draw, 50));
  features.back().labels = {1};
  features.push_back(feature_of(descriptor<SurfaceEdge>(), {line[4], line[5], line[1]}, draw, 50));
  features.push_back(feature_of(
      descriptor<ArcSegment>(),
      {at(draw), at(draw), -0.7, at(draw), at(draw), at(draw), at(draw), 12, 30, 41}, draw, 51));
  features.push_back(feature_of(descriptor<Corner>(), {at(draw), at(draw)}, draw, 52));
  features.back().labels = {1};
  return features;
}

PlanarPose<double> random_pose(std::mt19937_64& draw) {
  std::uniform_real_distribution<double> at(-4, 4);
  return {at(draw), at(draw), at(draw)};
}

Output set_of(const std::vector<Estimate>& features) {
  Output set = output_of<RangeFeatures>({2});
  for (const Estimate& feature : features) set.elements.push_back(feature);
  return set;
}

/// Moves a set by a mount, as a plan would.
ModuleRun moved(const Output& set, const Output& mount, FeaturesTransform::Options options = {},
                const Output* pose = nullptr) {
  FeaturesTransform module(std::move(options));
  Tick tick;
  tick.parameters = mount.estimate;
  tick.inputs = {&set};
  if (pose != nullptr) tick.inputs.push_back(pose);
  return run(module, tick);
}

Output mount_of(const PlanarPose<double>& pose, double deviation = 0) {
  return output_of<FeaturesTransform::Parameters>({pose.x, pose.z, pose.heading},
                                                  {deviation, 2 * deviation, deviation}, 200);
}

/// The pose that undoes another one.
template <typename T>
PlanarPose<T> inverse(const PlanarPose<T>& pose) {
  using std::cos;
  using std::sin;
  const T c = cos(pose.heading);
  const T s = sin(pose.heading);
  return {-c * pose.x - s * pose.z, s * pose.x - c * pose.z, -pose.heading};
}

double difference_of(double a, double b, const Component& component) {
  return component.geometry == Geometry::circular ? wrap_angle(a - b) : a - b;
}

TEST(FeaturesTransform, DerivativesAreThoseOfCentralDifferences) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 draw(seed);
    const PlaneAxes axes = seed % 2 == 0 ? PlaneAxes::robot : PlaneAxes::camera;
    const PlanarPose<double> pose = random_pose(draw);
    for (const Estimate& feature : random_features(draw)) {
      SCOPED_TRACE(feature.type->name);
      const MovedFeature here = move_feature(feature, pose, axes);
      constexpr double step = 1e-5;
      const auto check = [&](const auto& change, const auto& derivative) {
        const MovedFeature up = change(step);
        const MovedFeature down = change(-step);
        for (Eigen::Index i = 0; i < here.value.size(); ++i)
          EXPECT_NEAR(difference_of(up.value[i], down.value[i],
                                    feature.type->components[static_cast<std::size_t>(i)]) /
                          (2 * step),
                      derivative[i], 1e-7)
              << feature.type->components[static_cast<std::size_t>(i)].name;
      };
      for (std::size_t k = 0; k < feature.dimension(); ++k)
        check(
            [&](double change) {
              Estimate other = feature;
              other.value[k] += change;
              return move_feature(other, pose, axes);
            },
            here.by_feature.col(static_cast<Eigen::Index>(k)));
      for (std::size_t k = 0; k < 3; ++k)
        check(
            [&](double change) {
              PlanarPose<double> other = pose;
              components(other)[k] += change;
              return move_feature(feature, other, axes);
            },
            here.by_pose.col(static_cast<Eigen::Index>(k)));
    }
  }
}

TEST(FeaturesTransform, ALineStaysThroughItsEndsWithItsRhoNotNegative) {
  int flips = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 draw(seed);
    const PlanarPose<double> pose = random_pose(draw);
    const auto axes = seed % 2 == 0 ? PlaneAxes::robot : PlaneAxes::camera;
    const auto features = random_features(draw);
    const MovedFeature line = move_feature(features[0], pose, axes);
    const double rho = line.value[0];
    const double phi = line.value[1];
    EXPECT_GE(rho, 0);
    for (const int end : {2, 4})
      EXPECT_NEAR(line.value[end] * std::cos(phi) + line.value[end + 1] * std::sin(phi), rho,
                  1e-12);
    const MovedFeature edge = move_feature(features[1], pose, axes);
    EXPECT_NEAR(wrap_angle(edge.value[2] - phi), 0, 1e-12) << "the edge turns with its line";
    EXPECT_EQ(edge.value[0], line.value[4]);
    if (axes == PlaneAxes::robot)
      flips += std::abs(wrap_angle(phi - features[0].value[1] - pose.heading)) > 1 ? 1 : 0;
  }
  EXPECT_GT(flips, 20) << "or the test would not have seen the origin on the other side";
}

TEST(FeaturesTransform, MovesPlacesAsARotationDoes) {
  std::mt19937_64 draw(1);
  const PlanarPose<double> pose = random_pose(draw);
  const Estimate arc = random_features(draw)[2];
  const MovedFeature result = move_feature(arc, pose, PlaneAxes::robot);
  const Eigen::Rotation2Dd turn(pose.heading);
  for (const int x : {0, 3, 5}) {
    const Eigen::Vector2d place =
        turn * arc.vector().segment<2>(x) + Eigen::Vector2d(pose.x, pose.z);
    EXPECT_NEAR((result.value.segment<2>(x) - place).norm(), 0, 1e-12);
  }
  for (const int same : {2, 7, 8, 9}) EXPECT_EQ(result.value[same], arc.value[same]);
}

TEST(FeaturesTransform, TakesCameraAxesForXRightAndZForward) {
  // A wall 2 m ahead of the camera, from 1 m to the left to 0.5 m to the right of it.
  std::mt19937_64 draw(1);
  const Output set =
      set_of({feature_of(descriptor<LineSegment>(), line_through(-1, 2, 0.5, 2), draw)});
  const ModuleRun result =
      moved(set, mount_of({0.1, 0, 0}), {.from = "lep", .to = "robot", .axes = PlaneAxes::camera});
  ASSERT_TRUE(result.outcome);
  const Estimate& wall = result.output.elements[0];
  EXPECT_EQ(wall.frame, "robot");
  const std::vector<double> expected = {2.1, 0, 2.1, -1, 2.1, 0.5, 20, 3, 25};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(wall.value[i], expected[i], 1e-12) << i;
}

TEST(FeaturesTransform, ThereAndBackIsTheSetWithItsErrorsAgain) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 draw(seed);
    const Output set = set_of(random_features(draw));
    const PlanarPose<double> pose = random_pose(draw);
    // The way back has the very errors of the way there, so they cancel.
    const Output there = output_of<PlanarPose>(pose, {0.1, 0.2, 0.05}, 300);
    Output back = output_of<PlanarPose>(inverse(pose));
    Eigen::Matrix3d jacobian;
    constexpr double step = 1e-6;
    for (std::size_t k = 0; k < 3; ++k) {
      auto up = pose;
      auto down = pose;
      components(up)[k] += step;
      components(down)[k] -= step;
      const auto a = inverse(up);
      const auto b = inverse(down);
      for (std::size_t i = 0; i < 3; ++i)
        jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
            (components(a)[i] - components(b)[i]) / (2 * step);
    }
    const LineageTerm term{jacobian.data(), &there.estimate.lineage};
    compose({&term, 1}, 3, back.estimate.lineage);
    const Output none = mount_of({0, 0, 0});
    const ModuleRun world = moved(set, none, {.pose = PoseSource::input}, &there);
    ASSERT_TRUE(world.outcome);
    EXPECT_GT(world.output.elements[3].lineage.standard_deviation(0), 0.1);
    const ModuleRun again = moved(
        world.output, none, {.from = "world", .to = "robot", .pose = PoseSource::input}, &back);
    ASSERT_TRUE(again.outcome);
    ASSERT_EQ(again.output.elements.size(), set.elements.size());
    for (std::size_t e = 0; e < set.elements.size(); ++e) {
      const Estimate& before = set.elements[e];
      const Estimate& after = again.output.elements[e];
      EXPECT_EQ(after.frame, "robot");
      EXPECT_EQ(after.labels, before.labels);
      EXPECT_LT(difference(after, before.value).cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_LT((after.lineage.covariance() - before.lineage.covariance()).cwiseAbs().maxCoeff(),
                1e-9);
    }
  }
}

TEST(FeaturesTransform, FeaturesShareThePosesErrorsAndKeepTheirOwn) {
  std::mt19937_64 draw(5);
  const auto features = random_features(draw);
  const PlanarPose<double> pose = random_pose(draw);
  const Output mount = mount_of(pose, 0.1);
  const ModuleRun result = moved(set_of(features), mount);
  ASSERT_TRUE(result.outcome);
  const Eigen::MatrixXd pose_covariance = mount.estimate.lineage.covariance();
  for (std::size_t a = 0; a < features.size(); ++a)
    for (std::size_t b = 0; b < features.size(); ++b) {
      const MovedFeature of_a = move_feature(features[a], pose, PlaneAxes::robot);
      const MovedFeature of_b = move_feature(features[b], pose, PlaneAxes::robot);
      const Eigen::MatrixXd expected =
          of_a.by_feature * cross_covariance(features[a].lineage, features[b].lineage) *
              of_b.by_feature.transpose() +
          of_a.by_pose * pose_covariance * of_b.by_pose.transpose();
      EXPECT_LT(
          (cross_covariance(result.output.elements[a].lineage, result.output.elements[b].lineage) -
           expected)
              .cwiseAbs()
              .maxCoeff(),
          1e-12);
    }
}

TEST(FeaturesTransform, AMountOnAPoseIsOneAfterTheOther) {
  std::mt19937_64 draw(6);
  const Output set = set_of(random_features(draw));
  const Output mount = mount_of(random_pose(draw), 0.02);
  const Output pose = output_of<PlanarPose>(random_pose(draw), {0.1, 0.2, 0.05}, 300);
  const ModuleRun robot = moved(set, mount, {.from = "laser", .to = "robot"});
  ASSERT_TRUE(robot.outcome);
  const ModuleRun twice =
      moved(robot.output, mount_of({0, 0, 0}), {.pose = PoseSource::input}, &pose);
  const ModuleRun once = moved(set, mount, {.from = "laser", .pose = PoseSource::input}, &pose);
  ASSERT_TRUE(twice.outcome);
  ASSERT_TRUE(once.outcome);
  for (std::size_t e = 0; e < set.elements.size(); ++e) {
    const Estimate& a = once.output.elements[e];
    const Estimate& b = twice.output.elements[e];
    EXPECT_LT(difference(a, b.value).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((a.lineage.covariance() - b.lineage.covariance()).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(FeaturesTransform, AllocatesNothingWhileSetsShrinkAndGrow) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  std::mt19937_64 draw(11);
  Output set = set_of(random_features(draw));
  const Output mount = mount_of({0.2, -0.1, 0.3}, 0.01);
  FeaturesTransform module({});
  Tick tick;
  tick.parameters = mount.estimate;
  tick.inputs = {&set};
  const Elements all = set.elements;
  Output output;
  std::size_t before = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    set.elements = all;
    set.elements.resize(all.size() - i % 4);
    if (i == 10) before = allocation_count;
    const Outcome<> outcome = module.evaluate(tick.evaluation(), output);
    ASSERT_TRUE(outcome);
    EXPECT_EQ(output.elements.size(), set.elements.size());
  }
  EXPECT_EQ(allocation_count - before, 0u);
}

TEST(FeaturesTransform, WhereCorrelationIsUnknownTheCovarianceIsNotBelowWhatItCouldBe) {
  std::mt19937_64 draw(7);
  const Output set = set_of(random_features(draw));
  const Output pose = output_of<PlanarPose>(random_pose(draw), {0.1, 0.2, 0.05}, 300);
  const Output none = mount_of({0, 0, 0});
  FeaturesTransform module({.pose = PoseSource::input});
  const std::vector<const Output*> inputs = {&set, &pose};
  const Evaluation evaluation{
      .parameters = none.estimate, .inputs = inputs, .correlation_unknown = true};
  Output bound;
  ASSERT_TRUE(module.evaluate(evaluation, bound));
  const ModuleRun known = moved(set, none, {.pose = PoseSource::input}, &pose);
  for (std::size_t e = 0; e < set.elements.size(); ++e) {
    const Eigen::MatrixXd more =
        bound.elements[e].lineage.covariance() - known.output.elements[e].lineage.covariance();
    EXPECT_GT(more.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12);
    EXPECT_GT(more.trace(), 1e-4);
  }
}

TEST(FeaturesTransform, WhatIsNotFiniteOrNoFeatureIsAFault) {
  std::mt19937_64 draw(8);
  Output far = set_of({feature_of(descriptor<Corner>(), {1e308, 1e308}, draw)});
  EXPECT_EQ(fault_of(moved(far, mount_of({1e308, 0, 0})).outcome), "not_finite");
  const Output other = set_of({output_of<PlanarPose>({1, 2, 3}).estimate});
  const ModuleRun result = moved(other, mount_of({0, 0, 0}));
  EXPECT_EQ(fault_of(result.outcome), "bad_data");
  EXPECT_NE(result.outcome.fault().message.find("planar_pose"), std::string::npos);
}

}  // namespace
}  // namespace ilss
