// Rows and lines of feature files: factors of covariances, and what is wrong with a bad one.
#include "framework/record/feature_records.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "sensors/features/range_features.h"

namespace ilss {
namespace {

const PayloadDescriptor& set() { return descriptor<RangeFeatures>(); }

TEST(CovarianceFactor, GivesTheCovarianceAgainWhateverItsRankAndUnits) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 draw(seed);
    std::normal_distribution<double> normal;
    const auto n = static_cast<Eigen::Index>(1 + draw() % 10);
    const auto rank = static_cast<Eigen::Index>(draw() % static_cast<std::uint64_t>(n + 1));
    Eigen::MatrixXd g(n, rank);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index k = 0; k < rank; ++k) g(i, k) = normal(draw);
    for (Eigen::Index i = 0; i < n; ++i) g.row(i) *= std::pow(10.0, 4 * normal(draw));
    if (n > 1 && draw() % 3 == 0) g.row(n / 2).setZero();
    const Eigen::MatrixXd covariance = g * g.transpose();
    const auto factor = covariance_factor(covariance);
    ASSERT_TRUE(factor) << factor.fault().message;
    EXPECT_LE(factor->cols(), rank);
    const Eigen::MatrixXd again = *factor * factor->transpose();
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        EXPECT_LE(std::abs(again(i, j) - covariance(i, j)),
                  1e-13 * std::sqrt(covariance(i, i) * covariance(j, j)));
  }
}

std::string message_of(const Eigen::MatrixXd& covariance) {
  const auto factor = covariance_factor(covariance);
  return factor ? "fine" : factor.fault().message;
}

TEST(CovarianceFactor, SaysWhyAMatrixIsNoCovariance) {
  Eigen::Matrix2d matrix;
  matrix << 1, 0.5, 0.4, 1;
  EXPECT_EQ(message_of(matrix), "the covariance is not symmetric: 0.5 and 0.4");
  matrix << 1, 3, 3, 4;
  EXPECT_EQ(message_of(matrix), "a covariance of 3 between standard deviations of 1 and 2");
  matrix << -1, 0, 0, 1;
  EXPECT_EQ(message_of(matrix), "a variance of -1; expected 0 or more");
  matrix << 0, 0.1, 0.1, 1;
  EXPECT_EQ(message_of(matrix), "a covariance of 0.1 between standard deviations of 0 and 1");
  Eigen::Matrix3d three;
  three << 1, -0.9, -0.9, -0.9, 1, -0.9, -0.9, -0.9, 1;
  EXPECT_EQ(message_of(three),
            "the covariance is not positive semidefinite: its correlations have the eigenvalue "
            "-0.8");
}

TEST(CovarianceFactor, TakesASingularCovarianceThatWasWrittenWithSevenDigits) {
  const Eigen::Vector3d g(0.1, 0.3333333, 7.77);
  Eigen::MatrixXd rounded = g * g.transpose();
  for (double& x : rounded.reshaped()) x = std::stod(std::to_string(x * 1e4)) / 1e4;
  EXPECT_TRUE(covariance_factor(rounded));
}

constexpr std::string_view header =
    "tick,time,acquired,frame,type,kind,x,z,phi,covariance.x.x,covariance.x.z,covariance.z.z,"
    "covariance.phi.phi,landmark";

std::string row_message(std::string_view row) {
  const auto columns = FeatureColumns::read(header, set());
  if (!columns) return columns.fault().message;
  const auto parsed = columns->parse(row, "robot");
  return parsed ? "fine" : parsed.fault().message;
}

TEST(FeatureRows, AreReadByTheHeader) {
  const auto columns = FeatureColumns::read(header, set());
  ASSERT_TRUE(columns) << columns.fault().message;
  const auto row =
      columns->parse("7,1.5,1.25,\"robot\",corner,virtual,2,-3,,0.04,0.02,0.09,,door 5", "robot");
  ASSERT_TRUE(row) << row.fault().message;
  EXPECT_EQ(row->time.tick, 7);
  EXPECT_DOUBLE_EQ(row->time.age, 0.25);
  EXPECT_EQ(row->feature.type, &descriptor<Corner>());
  EXPECT_EQ(row->feature.value, (std::vector<double>{2, -3}));
  EXPECT_EQ(row->feature.labels, std::vector<int>{1});
  const Eigen::Matrix2d covariance = row->feature.factor * row->feature.factor.transpose();
  EXPECT_NEAR(covariance(0, 1), 0.02, 1e-15);
  EXPECT_NEAR(covariance(1, 1), 0.09, 1e-15);
}

TEST(FeatureRows, FramesInQuotesMayHoldCommas) {
  const auto columns = FeatureColumns::read(header, set());
  ASSERT_TRUE(columns);
  EXPECT_TRUE(columns->parse("7,1,1,\"a, \"\"b\"\"\",corner,real,2,-3,,1,,1,,", "a, \"b\""));
}

TEST(FeatureRows, SayWhatIsWrong) {
  EXPECT_EQ(row_message("7,1,1,robot,corner,real,2,-3,,1,,1,,"), "fine");
  EXPECT_EQ(row_message(R"("7","1","1","robot","corner","real","2","-3","","1","","1","","")"),
            "fine")
      << "cells in quotes, empty ones, too";
  EXPECT_EQ(row_message("7,1,1,robot,corner,real,2,-3,,1,,1,"),
            "the row has 13 cells; expected 14, as the header has");
  EXPECT_EQ(row_message("x,1,1,robot,corner,real,2,-3,,1,,1,,"),
            "column tick: expected a whole number, got 'x'");
  EXPECT_EQ(row_message("-7,1,1,robot,corner,real,2,-3,,1,,1,,"), "tick -7; expected 0 or more");
  EXPECT_EQ(row_message("7,1,2,robot,corner,real,2,-3,,1,,1,,"),
            "acquired at 2 s, after the tick's time, 1 s");
  EXPECT_EQ(row_message("7,1,1,world,corner,real,2,-3,,1,,1,,"),
            "in frame 'world'; expected 'robot'");
  EXPECT_EQ(row_message("7,1,1,robot,cornr,real,2,-3,,1,,1,,"),
            "unknown type 'cornr'; expected one of line_segment, arc_segment, corner, edge; did "
            "you mean 'corner'?");
  EXPECT_EQ(row_message("7,1,1,robot,corner,false,2,-3,,1,,1,,"),
            "unknown kind 'false'; expected one of real, virtual");
  EXPECT_EQ(row_message("7,1,1,robot,corner,real,nan,-3,,1,,1,,"),
            "column x: expected a number, got 'nan'");
  EXPECT_EQ(row_message("7,1,1,robot,corner,real,2,-3,1,1,,1,,"),
            "column phi: '1', but corner has no such thing");
  EXPECT_EQ(row_message("7,1,1,robot,edge,,2,-3,90,1,,1,1,"), "phi is 90 rad, more than a turn");
  EXPECT_EQ(row_message("7,1,1,robot,corner,real,2,-3,,,,1,,"),
            "column covariance.x.x: expected a number, got ''");
  EXPECT_EQ(row_message("7,1,1,robot,line_segment,,2,-3,,1,,1,,"),
            "column x: '2', but line_segment has no such thing");
}

TEST(FeatureRows, AHeaderThatIsNoneIsDeviceLost) {
  const auto message = [](std::string_view text) {
    const auto columns = FeatureColumns::read(text, set());
    if (columns) return std::string("fine");
    EXPECT_EQ(columns.fault().kind, FaultKind::device_lost);
    return columns.fault().message;
  };
  EXPECT_EQ(message("FLASER 3 1 2 3"),
            "the header has no column 'tick'; expected a CSV or JSON file of features, as ilss run "
            "--features writes it");
  EXPECT_EQ(message("tick,type,x,z,x"), "the column 'x' comes twice");
  EXPECT_EQ(message("tick,type,x,z,covariance.z.x"),
            "the column 'covariance.z.x' is of no two components of one type, in their order");
}

std::string line_message(const std::string& line) {
  const auto parsed = parse_feature_json(line, set(), "robot");
  return parsed ? (*parsed ? "a set" : "nothing") : parsed.fault().message;
}

const std::string json_corner =
    R"({"type":"corner","frame":"robot","components":[{"name":"x","unit":"m","value":2,"std":1},)"
    R"({"name":"z","unit":"m","value":-3,"std":1}],"labels":{"kind":"virtual"},)"
    R"("covariance":[[0.04,0.02],[0.02,0.09]]})";

std::string json_line(const std::string& feature) {
  return R"({"tick":4,"time":0.5,"output":{"type":"range_features","features":[)" + feature + "]}}";
}

std::string with(std::string text, const std::string& old, const std::string& other) {
  const std::size_t at = text.find(old);
  return at == std::string::npos ? "not found: " + old : text.replace(at, old.size(), other);
}

TEST(FeatureJson, IsATicksSetALine) {
  const auto parsed = parse_feature_json(json_line(json_corner) + ",", set(), "robot");
  ASSERT_TRUE(parsed) << parsed.fault().message;
  ASSERT_TRUE(*parsed);
  EXPECT_EQ((*parsed)->time.tick, 4);
  EXPECT_EQ((*parsed)->time.age, 0);
  ASSERT_EQ((*parsed)->features.size(), 1U);
  const RecordedFeature& corner = (*parsed)->features[0];
  EXPECT_EQ(corner.value, (std::vector<double>{2, -3}));
  EXPECT_EQ(corner.labels, std::vector<int>{1});
  EXPECT_NEAR((corner.factor * corner.factor.transpose())(1, 0), 0.02, 1e-15);
}

TEST(FeatureJson, SaysWhatIsWrong) {
  EXPECT_EQ(line_message(json_line("")), "a set") << "an empty one";
  EXPECT_EQ(line_message("["), "nothing");
  EXPECT_EQ(line_message(R"({"tick":1,"time":0,"outcome":"fault","output":null})"), "nothing");
  EXPECT_EQ(line_message(R"({"tick":1,)"),
            "expected a tick's JSON object on a line, got '{\"tick\":1'");
  EXPECT_EQ(line_message(R"({"tick":1,"time":0})"), "the output is ''; expected range_features");
  EXPECT_EQ(line_message(R"({"tick":1.5,"time":0})"), "tick: expected a whole number, got 1.5");
  EXPECT_EQ(line_message(json_line("3")),
            "feature 1: unknown type ''; expected line_segment, arc_segment, corner or edge");
  EXPECT_EQ(line_message(json_line(with(json_corner, "virtual", "false"))),
            "feature 1: unknown kind 'false'; expected one of real, virtual");
  EXPECT_EQ(line_message(json_line(with(json_corner, R"("z")", R"("y")"))),
            "feature 1: component 2: expected 'z', got 'y'");
  EXPECT_EQ(line_message(json_line(with(json_corner, "-3", "null"))),
            "feature 1: z: expected a number, got null");
  EXPECT_EQ(line_message(json_line(with(json_corner, "[0.02,0.09]", "[0.02]"))),
            "feature 1: covariance: expected 2 rows of 2");
  EXPECT_EQ(line_message(json_line(with(json_corner, "[0.02,0.09]", "[0.03,0.09]"))),
            "feature 1: the covariance is not symmetric: 0.02 and 0.03");
}

TEST(FeatureJson, SourcesAreRandomOrSystematicAndEachIsToldOnce) {
  const auto with_sources = [](const std::string& sources) {
    return line_message(
        with(json_line(""), R"("features":)", R"("sources":[)" + sources + R"(],"features":)"));
  };
  const std::string one = R"({"owner":"x","column":0,"kind":"random","tick":1})";
  EXPECT_EQ(with_sources(one), "a set");
  EXPECT_EQ(with_sources(one + "," + one), "source 2: the same as one before it");
  EXPECT_EQ(with_sources(R"({"owner":"x","column":0,"kind":"randm","tick":1})"),
            "source 1: unknown kind 'randm'; expected random or systematic");
}

TEST(FeatureJson, NestedAsDeepAsALineIsLongIsAnErrorOnly) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_EQ(line_message(R"({"tick":)" + deep + R"(,"time":0})"),
            "tick: expected a whole number, got an array");
  EXPECT_EQ(line_message(R"({"tick":1,"time":)" + deep + "}"),
            "time: expected a number, got an array");
}

}  // namespace
}  // namespace ilss
