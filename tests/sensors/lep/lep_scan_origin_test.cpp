// The x calibration: where the laser turns, from stripe edges.
#include "sensors/lep/lep_scan_origin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "framework/estimate/consistency.h"

namespace ilss {
namespace {

const LepScanOrigin truth{-0.043, 0.06, 0.009, Eigen::Matrix3d::Zero()};

/// Edges every 50 mm on flat targets at these depths.
std::vector<StripeEdge> edges_at(const std::vector<double>& depths) {
  std::vector<StripeEdge> edges;
  for (const double z : depths)
    for (int edge = -4; edge <= 4; ++edge) {
      const double x = 0.05 * edge;
      edges.push_back({std::atan2(x - truth.x, z - truth.z) - truth.projected_vergence, x, z});
    }
  return edges;
}

TEST(LepScanOrigin, IsExactOnExactEdges) {
  const auto fit = fit_scan_origin(edges_at({0.6, 1.2, 2.0}));
  ASSERT_TRUE(fit) << fit.fault().message;
  EXPECT_NEAR(fit->origin.x, truth.x, 1e-10);
  EXPECT_NEAR(fit->origin.z, truth.z, 1e-10);
  EXPECT_NEAR(fit->origin.projected_vergence, truth.projected_vergence, 1e-10);
}

TEST(LepScanOrigin, LiesOnTheLaserLines) {
  const auto fit = fit_scan_origin(edges_at({0.6, 1.2, 2.0}));
  ASSERT_TRUE(fit);
  const LepScanOrigin& o = fit->origin;
  for (const StripeEdge& edge : edges_at({0.9}))
    EXPECT_NEAR(o.x + (edge.z - o.z) * std::tan(edge.scan_angle + o.projected_vergence), edge.x,
                1e-10);
}

TEST(LepScanOrigin, IsAsWrongAsItSays) {
  const std::uint32_t seed = 21;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  constexpr double angle_deviation = 2e-4;
  std::normal_distribution<double> noise(0, angle_deviation);
  ConsistencyStatistic honesty;
  for (int i = 0; i < 2000; ++i) {
    auto edges = edges_at({0.6, 0.8, 1.0, 1.2, 1.5, 2.0});
    for (StripeEdge& edge : edges) edge.scan_angle += noise(random);
    const auto fit = fit_scan_origin(edges);
    ASSERT_TRUE(fit) << fit.fault().message;
    const Eigen::Vector3d error(fit->origin.x - truth.x, fit->origin.z - truth.z,
                                fit->origin.projected_vergence - truth.projected_vergence);
    // The covariance comes from the residuals; here it is held against the known sd.
    const double known = std::pow(angle_deviation / fit->residual, 2);
    honesty.add(normalized_squared_error(error, known * fit->origin.covariance));
    EXPECT_NEAR(fit->residual / angle_deviation, 1, 0.5);
  }
  EXPECT_TRUE(honesty.consistent(0.99)) << honesty.mean();
}

TEST(LepScanOrigin, OneRayLeavesItOpen) {
  std::vector<StripeEdge> edges(8, {0.1, 0.2, 1.0});
  const auto fit = fit_scan_origin(edges);
  ASSERT_TRUE(fit.is_fault());
  EXPECT_EQ(fit.fault().kind, FaultKind::degenerate);
  EXPECT_NE(fit.fault().message.find("origin_x"), std::string::npos) << fit.fault().message;
}

TEST(LepScanOrigin, RefusesFewOrBadEdges) {
  auto edges = edges_at({0.6, 1.2});
  edges.resize(4);
  EXPECT_EQ(fit_scan_origin(edges).fault().kind, FaultKind::degenerate);
  edges = edges_at({0.6, 1.2});
  edges[2].x = std::nan("");
  EXPECT_EQ(fit_scan_origin(edges).fault().kind, FaultKind::bad_data);
}

}  // namespace
}  // namespace ilss
