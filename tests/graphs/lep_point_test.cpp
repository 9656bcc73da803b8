// The shipped graph of one LEP reading: its calibration is a file, and stays one systematic error.
#include <gtest/gtest.h>

#include "framework/graph/plan.h"
#include "framework/graph/system.h"
#include "sensors/register.h"

namespace ilss {
namespace {

TEST(LepPoint, CalibrationIsOneSystematicErrorOfEveryPoint) {
  Registry registry;
  register_sensors(registry);
  Diagnostics diagnostics;
  const auto plan = read_plan(std::filesystem::path(ILSS_SOURCE_DIR) / "graphs/lep_point.yaml",
                              registry, {}, diagnostics);
  for (const Diagnostic& wrong : diagnostics.sorted()) ADD_FAILURE() << format_diagnostic(wrong);
  ASSERT_TRUE(plan);
  System system(*plan, 1);
  const auto lineage_at = [&](double time) {
    system.evaluate(time_at(time));
    return system.node(plan->outputs.front()).output().estimate.lineage;
  };
  const Lineage first = lineage_at(0);
  const Lineage second = lineage_at(0.1);
  double systematic = 0;  // of the range
  for (std::size_t k = 0; k < first.size(); ++k) {
    // The noise current's own error is part of what the detector states, and moves no reading.
    if (!first.sources()[k].persistent() || first.column(k)[0] == 0) continue;
    EXPECT_EQ(plan->owners[first.sources()[k].owner].name, "lep");
    systematic += first.column(k)[0] * first.column(k)[0];
  }
  EXPECT_GT(systematic, 0);
  EXPECT_LT(systematic, 0.05 * first.variance(0));
  // Two readings share it, and nothing else.
  EXPECT_NEAR(cross_covariance(first, second)(0, 0) / systematic, 1, 1e-12);
}

}  // namespace
}  // namespace ilss
