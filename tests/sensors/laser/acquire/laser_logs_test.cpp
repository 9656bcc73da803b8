// Whole logs of real laser range finders, where they are at hand (../shared beside the project):
// they run without faults, and what they show is as uncertain as it is said to be.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <filesystem>
#include <map>
#include <sstream>

#include "framework/estimate/angle.h"
#include "framework/estimate/consistency.h"
#include "framework/record/text_log.h"
#include "sensors/laser/acquire/laser_log.h"
#include "sensors/laser/features/laser_features.h"
#include "sensors/laser/segment/breakpoints.h"
#include "sensors/laser/segment/maximum_likelihood_segments.h"
#include "tests/sensors/laser/features/simulated_readings.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

const std::filesystem::path log_folder =
    std::filesystem::path(ILSS_SOURCE_DIR) / "../shared/data/laser";

#define SKIP_WITHOUT(file)            \
  if (!std::filesystem::exists(file)) \
  GTEST_SKIP() << "by design: the whole log is not here: " << (file)

/// A log, taken scan by scan through breakpoints and a segmenter.
class SegmentedLog {
 public:
  using Segments = Segmenter<MaximumLikelihoodSegments>;

  explicit SegmentedLog(const LaserLog::Options& options, const SegmentRule& rule = {})
      : log_(options), breakpoints_({}), segmenter_({.rule = rule}) {}

  /// Goes on to the next scan; false at the log's end. A scan that shows nothing has no segments.
  bool next() {
    clusters_ = {};
    segments_ = {};
    clusters_.estimate = segments_.estimate = Estimate(descriptor<SegmentedScan>(), "laser");
    Tick tick{.parameters = Estimate(descriptor<LaserLog::Parameters>()), .tick = ++scans_};
    scan_.estimate = Estimate(descriptor<LaserScan>(), "laser");
    auto outcome = log_.open();
    if (outcome) outcome = log_.evaluate(tick.evaluation(), scan_);
    if (!outcome) {
      EXPECT_EQ(fault_of(outcome), "end_of_data") << outcome.fault().message;
      return false;
    }
    tick.inputs = {&scan_};
    if (const auto found = breakpoints_.evaluate(tick.evaluation(), clusters_); !found)
      return is_empty(found);
    tick.inputs = {&clusters_};
    const auto found = segmenter_.evaluate(tick.evaluation(), segments_);
    return found ? true : is_empty(found);
  }
  const Output& segments() const { return segments_; }
  std::int64_t scans() const { return scans_; }

 private:
  bool is_empty(const Outcome<>& outcome) {
    EXPECT_EQ(fault_of(outcome), "no_detection") << outcome.fault().message;
    segments_ = clusters_ = {};
    clusters_.estimate = segments_.estimate = Estimate(descriptor<SegmentedScan>(), "laser");
    return true;
  }

  LaserLog log_;
  Breakpoints breakpoints_;
  Segments segmenter_;
  Output scan_, clusters_, segments_;
  std::int64_t scans_ = -1;
};

/// SICK LMS 200 by its data sheet: 5 mm of noise; these logs tell centimetres.
LaserLog::Options sick_log(const std::string& name) {
  LaserLog::Options options;
  options.file = log_folder / name;
  options.range_std = 0.005;
  options.quantum = 0.01;
  options.no_return = 40;
  return options;
}

/// How two fits of one thing differ, over their covariances together.
NormalizedError difference_of(const LaserLineFit& a, const LaserLineFit& b) {
  const Eigen::Vector2d error(a.rho - b.rho, wrap_angle(a.alpha - b.alpha));
  Eigen::Matrix2d covariance = a.covariance + b.covariance;
  covariance(0, 0) += a.second_order_variance() + b.second_order_variance();
  return normalized_squared_error(error, covariance);
}

NormalizedError difference_of(const LaserArcFit& a, const LaserArcFit& b) {
  return normalized_squared_error(Eigen::Vector3d(a.x - b.x, a.y - b.y, a.radius - b.radius),
                                  a.covariance + b.covariance +
                                      a.second_order() * a.second_order().transpose() +
                                      b.second_order() * b.second_order().transpose());
}

/// Fits the odd and the even ones of every `stride`-th beam of each feature apart, and judges how
/// they differ. A SICK at half a degree takes its odd and even beams in two turns of the mirror,
/// which from a robot that drives are two scans: with a stride of 2 these are judged apart.
ConsistencyStatistic odd_against_even(const LaserLog::Options& options, std::size_t stride) {
  ConsistencyStatistic statistic;
  SegmentedLog log(options);
  SegmentedPoints scan;
  while (log.next()) {
    EXPECT_TRUE(scan.read(log.segments()));
    const LaserNoise noise = noise_of(log.segments().estimate);
    for (const ReadingRun& run : scan.runs()) {
      const auto whole = fit_laser_segment(scan.points(), run, noise, {}, {});
      if (!whole) continue;  // neither line nor arc: no feature
      for (std::size_t turn = 0; turn < stride; ++turn) {
        std::array<std::vector<ScanPoint>, 2> halves;
        for (std::size_t i = run.begin; i < run.end; ++i)
          if (i % stride == turn) halves[i / stride % 2].push_back(scan.points()[i]);
        if (std::min(halves[0].size(), halves[1].size()) < 4) continue;
        if (whole->arc) {
          const auto a = fit_laser_arc(halves[0], noise);
          const auto b = fit_laser_arc(halves[1], noise);
          if (a && b) statistic.add(difference_of(*a, *b));
        } else {
          const auto a = fit_laser_line(halves[0], noise);
          const auto b = fit_laser_line(halves[1], noise);
          if (a && b) statistic.add(difference_of(*a, *b));
        }
      }
    }
  }
  EXPECT_GT(log.scans(), 0);
  return statistic;
}

class SickLog : public testing::TestWithParam<std::pair<const char*, std::size_t>> {};

// Within the bounds on all logs, by the data sheet's noise.
TEST_P(SickLog, OddAndEvenBeamsDifferAsTheirErrorsSay) {
  const auto [name, stride] = GetParam();
  SKIP_WITHOUT(log_folder / name);
  const ConsistencyStatistic statistic = odd_against_even(sick_log(name), stride);
  RecordProperty("pairs", static_cast<int>(statistic.count()));
  RecordProperty("nees_per_dof", std::to_string(statistic.mean()));
  std::printf("%s: %zu pairs, NEES per degree of freedom %.3f\n", name, statistic.count(),
              statistic.mean());
  EXPECT_GT(statistic.count(), 1000u);
  EXPECT_GT(statistic.mean(), 0.8);
  EXPECT_LT(statistic.mean(), 1.25);
}

INSTANTIATE_TEST_SUITE_P(Logs, SickLog,
                         testing::Values(std::pair("intel-corrected.log.gz", 1),
                                         std::pair("freiburg-101-corrected.log.gz", 2),
                                         std::pair("freiburg-079-corrected.log.gz", 2)),
                         [](const auto& log) {
                           const std::string name = log.param.first;
                           return name[0] == 'i'          ? std::string("Intel")
                                  : name.find("101") != 0 ? "Freiburg" + name.substr(9, 3)
                                                          : name;
                         });

/// The lines of a URG log: wheel ticks left and right.
std::vector<std::pair<int, int>> wheel_ticks(const std::filesystem::path& path) {
  std::vector<std::pair<int, int>> ticks;
  const auto log = TextLog::open(path);
  EXPECT_TRUE(log);
  for (std::size_t i = 0; i < (*log)->lines(); ++i) {
    std::istringstream line{std::string((*log)->line(i))};
    double time = 0;
    double unused = 0;
    std::pair<int, int> wheels;
    if (line >> time >> unused >> wheels.first >> wheels.second) ticks.push_back(wheels);
  }
  return ticks;
}

std::vector<Estimate> lines_of(const Output& segments) {
  LaserFeatures features({});
  Tick tick{.inputs = {&segments}};
  Output output;
  output.estimate = Estimate(descriptor<RangeFeatures>(), "robot");
  std::vector<Estimate> lines;
  if (!features.evaluate(tick.evaluation(), output)) return lines;
  for (const Estimate& element : output.elements)
    if (element.type->name == LineSegment<double>::name) lines.push_back(element);
  return lines;
}

double overlap(const Estimate& a, const Estimate& b) {
  const auto p = payload_of<LineSegment>(a);
  const auto q = payload_of<LineSegment>(b);
  const double both =
      std::min(p.last_reading, q.last_reading) - std::max(p.first_reading, q.first_reading) + 1;
  const double either =
      std::max(p.last_reading, q.last_reading) - std::min(p.first_reading, q.first_reading) + 1;
  return both / either;
}

TEST(UrgLog, PairsOfScansThatStandStillShowTheSame) {
  const auto path = log_folder / "urg04lx-exp1.dat.gz";
  SKIP_WITHOUT(path);
  LaserLog::Options options;
  options.file = path;
  options.format = LaserLogFormat::urg;
  options.range_std = 0.02;  // URG-04LX, data sheet: 1 % of the range beyond a metre, here at two
  options.quantum = 0.001;
  options.no_return = 5.6;
  const auto ticks = wheel_ticks(path);
  SegmentedLog log(options, {.least_readings = 8, .least_length = 0.2});
  ConsistencyStatistic statistic;
  std::vector<Estimate> before;
  int pairs = 0;
  int inside = 0;
  for (std::size_t i = 0; log.next(); ++i) {
    std::vector<Estimate> lines = lines_of(log.segments());
    ASSERT_LT(i, ticks.size());
    if (i > 0 && ticks[i] == ticks[i - 1]) {
      ++pairs;
      for (const Estimate& line : lines)
        for (const Estimate& other : before) {
          if (overlap(line, other) < 0.7) continue;
          const Eigen::Vector2d error(line.value[0] - other.value[0],
                                      wrap_angle(line.value[1] - other.value[1]));
          const NormalizedError difference =
              normalized_squared_error(error, line.lineage.covariance().topLeftCorner<2, 2>() +
                                                  other.lineage.covariance().topLeftCorner<2, 2>());
          statistic.add(difference);
          inside += difference.value < chi_square_quantile(2, 0.95) ? 1 : 0;
        }
    }
    before = std::move(lines);
  }
  std::printf("%d pairs, %zu lines, NEES per degree of freedom %.3f, %d inside 95 %%\n", pairs,
              statistic.count(), statistic.mean(), inside);
  EXPECT_GE(pairs, 40);
  ASSERT_GT(statistic.count(), 40u);
  EXPECT_GT(inside, 0.93 * static_cast<double>(statistic.count()));
}

}  // namespace
}  // namespace ilss
