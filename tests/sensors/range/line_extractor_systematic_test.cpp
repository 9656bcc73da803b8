// Calibration's errors in lines: they do not average out, and the stated errors say so.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "framework/estimate/random.h"
#include "sensors/features/wall_from_segments.h"
#include "tests/sensors/features/feature_run.h"

namespace ilss {
namespace {

/// The first four elements (f, d, gamma, s) of graphs/data/lep_calibration.yaml's covariance.
Eigen::Matrix4d fitted_covariance() {
  Eigen::Matrix4d c;
  c << 1.76534906601181e-09, -2.29639036999009e-09, -3.46627446296476e-09, 2.89750019848484e-09,
      -2.29639036999009e-09, 4.7188643556398e-09, 6.43628147603846e-09, 2.75249439571572e-09,
      -3.46627446296476e-09, 6.43628147603846e-09, 9.42232993427833e-09, 5.39089590116312e-09,
      2.89750019848484e-09, 2.75249439571572e-09, 5.39089590116312e-09, 7.20835449615384e-08;
  return c;
}

/// Ten times the standard deviations of the calibration that ships.
Eigen::Matrix4d calibration_factor() { return (100 * fitted_covariance()).llt().matrixL(); }

/// A rig whose ranging has a calibration redrawn about the truth, and states that uncertainty.
LepRig redrawn(const Scene& scene, std::uint64_t seed) {
  LepRig rig(scene);
  RandomBits random(seed);
  const Eigen::Matrix4d factor = calibration_factor();
  Eigen::Vector4d z;
  for (int i = 0; i < 4; ++i) z[i] = draw_normal(random);
  const Eigen::Vector4d change = factor * z;
  for (std::size_t i = 0; i < 4; ++i)
    rig.ranging_parameters.value[i] += change[static_cast<Eigen::Index>(i)];
  for (std::uint32_t k = 0; k < 4; ++k) {
    std::vector<double> column(rig.ranging_parameters.dimension(), 0.0);
    for (std::size_t i = 0; i < 4; ++i) column[i] = factor(static_cast<Eigen::Index>(i), k);
    rig.ranging_parameters.lineage.add({50, k, persistent_tick}, column);
  }
  return rig;
}

struct Averaged {
  ConsistencyStatistic lines;
  ConsistencyStatistic as_if_random;  ///< were the calibration's error averaged out
};

// "With a calibration uncertainty ten times the fitted one, 100 scans averaged."
TEST(LineExtractorSystematic, AMeanOfAHundredScansIsAsWrongAsItSays) {
  const std::uint64_t seed = 201;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  const Scene scene = edge_scene(1, 120 * degree);
  const InverseLine truth = line_of({}, scene.walls[0]);
  Averaged averaged;
  constexpr int runs = 200;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const LepRig rig = redrawn(scene, derive_seed(seed, run));
    LineExtractor extractor({.memory = 100});
    ModuleRun result;
    for (std::int64_t tick = 0; tick < 100; ++tick)
      result =
          extract(extractor,
                  rig.scan(derive_seed(seed + run, 1000 + static_cast<std::uint64_t>(tick))), tick);
    ASSERT_TRUE(result.outcome);
    const auto lines = elements_of<LineSegment>(result.output);
    ASSERT_EQ(lines.size(), 2u);
    averaged.lines.add(error_of(*lines[0], 0, rho_phi(truth)));
    Lineage without(7);
    for (std::size_t k = 0; k < lines[0]->lineage.size(); ++k) {
      std::vector<double> column(lines[0]->lineage.column(k).begin(),
                                 lines[0]->lineage.column(k).end());
      if (lines[0]->lineage.sources()[k].persistent())
        for (double& v : column) v /= 10;
      without.add(lines[0]->lineage.sources()[k], column);
    }
    Estimate confident = *lines[0];
    confident.lineage = without;
    averaged.as_if_random.add(error_of(confident, 0, rho_phi(truth)));
  }
  EXPECT_TRUE(averaged.lines.consistent(0.99)) << averaged.lines.mean();
  EXPECT_FALSE(averaged.as_if_random.consistent(0.99))
      << "the test would not see it if calibration errors were averaged out";
}

TEST(LineExtractorSystematic, ALineSharesItsCalibrationsErrorWithTheOther) {
  const LepRig rig = redrawn(edge_scene(1, 120 * degree), 1);
  LineExtractor extractor({});
  const ModuleRun result = extract(extractor, rig.scan(1));
  ASSERT_TRUE(result.outcome);
  const auto lines = elements_of<LineSegment>(result.output);
  ASSERT_EQ(lines.size(), 2u);
  const Eigen::MatrixXd shared = cross_covariance(lines[0]->lineage, lines[1]->lineage);
  EXPECT_GT(shared(0, 0), 1e-8);
  for (const Source& source : lines[0]->lineage.sources())
    EXPECT_TRUE(source.owner == 1 || (source.owner == 50 && source.persistent()));
}

// Errors that are the same in every scan, as a change of the calibration changes the lines.
TEST(LineExtractorSystematic, CalibrationColumnsAreWhatAChangedCalibrationDoes) {
  LepRig rig(edge_scene(1, 120 * degree));
  const Output images = rig.images(4);
  LineExtractor extractor({});
  for (std::size_t parameter = 0; parameter < 7; ++parameter) {
    LepRig uncertain = rig;
    const double by = 1e-6;
    uncertain.ranging_parameters.lineage.add({50, 0, persistent_tick}, parameter, by);
    const ModuleRun stated = extract(extractor, uncertain.ranges(images));
    LepRig changed = rig;
    changed.ranging_parameters.value[parameter] += by;
    const ModuleRun moved = extract(extractor, changed.ranges(images));
    ASSERT_EQ(stated.output.elements.size(), moved.output.elements.size());
    for (std::size_t e = 0; e < stated.output.elements.size(); ++e) {
      const Estimate& before = stated.output.elements[e];
      const Estimate& after = moved.output.elements[e];
      std::vector<double> column(before.dimension(), 0.0);
      for (std::size_t k = 0; k < before.lineage.size(); ++k)
        if (before.lineage.sources()[k].owner == 50)
          column.assign(before.lineage.column(k).begin(), before.lineage.column(k).end());
      for (std::size_t i = 0; i < before.dimension(); ++i)
        EXPECT_NEAR((after.value[i] - before.value[i]) / by, column[i] / by,
                    0.02 * std::abs(column[i] / by) + 0.02)
            << before.type->name << " " << before.type->components[i].name << ", parameter "
            << parameter;
    }
  }
}

}  // namespace
}  // namespace ilss
