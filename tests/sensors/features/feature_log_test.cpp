// Feature sets from files: ticks, faults with their place, and files of every kind of damage.
#include "sensors/features/feature_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "framework/estimate/random.h"
#include "sensors/features/range_features.h"
#include "tests/sensors/module_run.h"

namespace ilss {
namespace {

class FeatureLogFile : public testing::Test {
 protected:
  FeatureLogFile()
      : path_(std::filesystem::temp_directory_path() /
              (std::string("ilss_feature_log_") +
               testing::UnitTest::GetInstance()->current_test_info()->name())) {}
  ~FeatureLogFile() override { std::filesystem::remove(path_); }

  FeatureLog log(const std::string& text, bool skip_bad = false) const {
    std::ofstream(path_, std::ios::binary) << text;
    return FeatureLog({.file = path_, .frame = "robot", .skip_bad = skip_bad});
  }
  std::string at(int line, const std::string& what) const {
    return path_.string() + ":" + std::to_string(line) + ": " + what;
  }

  std::filesystem::path path_;
};

const std::string header =
    "tick,time,acquired,frame,type,kind,x,z,phi,covariance.x.x,covariance.x.z,covariance.z.z,"
    "covariance.phi.phi\n";
const std::string rows[] = {"3,0.3,0.2,robot,corner,real,1,2,,0.01,0,0.01,\n",
                            "3,0.3,0.2,robot,edge,,3,4,0.5,0.01,0.01,0.01,0.04\n",
                            "5,0.5,0.5,robot,corner,virtual,5,6,,0,0,0,\n"};
const std::string csv = header + rows[0] + rows[1] + rows[2];

const std::string json =
    R"([
{"tick":3,"time":0.3,"output":{"type":"range_features","features":[{"type":"corner","frame":"robot","components":[{"name":"x","value":1},{"name":"z","value":2}],"labels":{"kind":"real"},"covariance":[[0.01,0],[0,0.01]]}]}},
{"tick":4,"time":0.4,"output":null},
{"tick":5,"time":0.5,"output":{"type":"range_features","features":[]}}
]
)";

TEST_F(FeatureLogFile, GivesASetATickAndThenEnds) {
  FeatureLog module = log(csv);
  for (int pass = 0; pass < 2; ++pass) {
    const ModuleRun first = run(module, {.tick = 10});
    ASSERT_TRUE(first.outcome) << first.outcome.fault().message;
    ASSERT_EQ(first.output.elements.size(), 2U);
    EXPECT_EQ(first.output.elements[0].type, &descriptor<Corner>());
    EXPECT_EQ(first.output.elements[1].type, &descriptor<SurfaceEdge>());
    EXPECT_DOUBLE_EQ(first.output.elements[1].value[2], 0.5);
    EXPECT_EQ(first.output.acquired.oldest, time_at(0.9)) << "as old as when it was written";
    const ModuleRun second = run(module, {.tick = 11});
    ASSERT_TRUE(second.outcome);
    ASSERT_EQ(second.output.elements.size(), 1U);
    EXPECT_EQ(second.output.elements[0].labels, std::vector<int>{1});
    EXPECT_TRUE(second.output.elements[0].lineage.empty()) << "an exact corner";
    EXPECT_EQ(fault_of(run(module, {.tick = 12}).outcome), "end_of_data");
    EXPECT_EQ(module.note(), "");
    module.reset();
  }
}

TEST_F(FeatureLogFile, ElementsHaveSourcesOfTheirOwnAndSayThatThisIsNotAll) {
  FeatureLog module = log(csv);
  const ModuleRun result = run(module, {.tick = 10, .owner = 4});
  ASSERT_TRUE(result.outcome);
  const Estimate& corner = result.output.elements[0];
  const Estimate& edge = result.output.elements[1];
  EXPECT_TRUE(result.output.estimate.correlation_unknown)
      << "which the framework gives its elements";
  EXPECT_EQ(edge.lineage.size(), 2U) << "x and z are one error";
  EXPECT_NEAR(edge.lineage.covariance()(0, 1), 0.01, 1e-15);
  EXPECT_TRUE(cross_covariance(corner.lineage, edge.lineage).isZero(0));
  for (const Source& source : edge.lineage.sources()) {
    EXPECT_EQ(source.owner, 4U);
    EXPECT_EQ(source.tick, 10);
  }
}

TEST_F(FeatureLogFile, ReadsJsonAndLeavesOutTicksWithoutASet) {
  FeatureLog module = log(json);
  const ModuleRun first = run(module, {});
  ASSERT_TRUE(first.outcome) << first.outcome.fault().message;
  ASSERT_EQ(first.output.elements.size(), 1U);
  EXPECT_NEAR(first.output.elements[0].lineage.variance(0), 0.01, 1e-15);
  const ModuleRun second = run(module, {.tick = 1});
  ASSERT_TRUE(second.outcome);
  EXPECT_TRUE(second.output.elements.empty());
  EXPECT_EQ(fault_of(run(module, {.tick = 2}).outcome), "end_of_data");
}

TEST_F(FeatureLogFile, ABadRowIsTheFaultOfItsSetOrLeftOutAndCounted) {
  const std::string damaged = header + rows[0] + "3,0.3,0.2,robot,edge\n" + rows[2] +
                              "5,garbage\n" + "6,0.6,0.6,robot,corner,real,5,6,,0,0,0,\n";
  const std::string first_fault = at(3, "the row has 5 cells; expected 13, as the header has");
  FeatureLog strict = log(damaged);
  ModuleRun result = run(strict, {});
  EXPECT_EQ(fault_of(result.outcome), "bad_data");
  EXPECT_EQ(result.outcome.fault().message, first_fault);
  result = run(strict, {.tick = 1});
  EXPECT_EQ(result.outcome.fault().message,
            at(5, "the row has 2 cells; expected 13, as the header has"));
  EXPECT_TRUE(run(strict, {.tick = 2}).outcome);
  EXPECT_EQ(fault_of(run(strict, {.tick = 3}).outcome), "end_of_data");

  FeatureLog tolerant = log(damaged, true);
  for (int tick = 0; tick < 3; ++tick) {
    result = run(tolerant, {.tick = tick});
    ASSERT_TRUE(result.outcome);
    EXPECT_EQ(result.output.elements.size(), 1U);
  }
  EXPECT_EQ(fault_of(run(tolerant, {.tick = 3}).outcome), "end_of_data");
  EXPECT_EQ(tolerant.note(), "2 bad lines left out, the first: " + first_fault);
}

TEST_F(FeatureLogFile, ABadLineOfJsonIsAFaultOrLeftOutAndCounted) {
  const std::string damaged = json.substr(0, json.find("{\"tick\":4")) + "{\"tick\":3.5},\n" +
                              json.substr(json.find("{\"tick\":5"));
  FeatureLog strict = log(damaged);
  EXPECT_TRUE(run(strict, {}).outcome);
  EXPECT_EQ(run(strict, {.tick = 1}).outcome.fault().message,
            at(3, "tick: expected a whole number, got 3.5"));
  EXPECT_TRUE(run(strict, {.tick = 2}).outcome);
  FeatureLog tolerant = log(damaged, true);
  EXPECT_TRUE(run(tolerant, {}).outcome);
  EXPECT_TRUE(run(tolerant, {.tick = 1}).outcome);
  EXPECT_EQ(tolerant.note(),
            "1 bad line left out, the first: " + at(3, "tick: expected a whole number, got 3.5"));
}

TEST_F(FeatureLogFile, TicksGoUp) {
  FeatureLog module = log(header + rows[2] + rows[0]);
  EXPECT_TRUE(run(module, {}).outcome);
  EXPECT_EQ(run(module, {.tick = 1}).outcome.fault().message, at(3, "tick 3 after tick 5"));
}

TEST_F(FeatureLogFile, FilesWithoutFeaturesAreDeviceLost) {
  const std::string binary("tick\0\1\2\3", 8);
  for (const std::string& text :
       {std::string(), binary, std::string("\n\n"), std::string("FLASER 2 1 1 0 0 0\n"), header,
        std::string("[\n]\n")}) {
    SCOPED_TRACE(text);
    FeatureLog module = log(text);
    const ModuleRun result = run(module, {});
    EXPECT_EQ(fault_of(result.outcome), "device_lost");
    EXPECT_NE(result.outcome.fault().message.find(path_.string()), std::string::npos);
  }
  FeatureLog missing({.file = "/no/such/file.csv"});
  EXPECT_EQ(fault_of(run(missing, {}).outcome), "device_lost");
}

/// A run to the end of a file, whatever is in it: every set is finite, every fault says where.
void play(FeatureLog& module, const std::string& file) {
  for (int tick = 0; tick < 20; ++tick) {
    const ModuleRun result = run(module, {.tick = tick});
    if (result.outcome.is_fault()) {
      EXPECT_NE(result.outcome.fault().message.find(file), std::string::npos);
      const FaultKind kind = result.outcome.fault().kind;
      if (kind != FaultKind::bad_data) {
        EXPECT_TRUE(kind == FaultKind::end_of_data || kind == FaultKind::device_lost);
        return;
      }
      continue;
    }
    ASSERT_TRUE(result.outcome);
    for (const Estimate& element : result.output.elements) {
      EXPECT_TRUE(element.vector().allFinite());
      EXPECT_TRUE(element.lineage.covariance().allFinite());
      EXPECT_EQ(element.dimension(), element.type->dimension());
      EXPECT_EQ(element.labels.size(), element.type->labels.size());
    }
  }
  ADD_FAILURE() << "more sets than the file has lines";
}

TEST_F(FeatureLogFile, DamagedFilesGiveFaultsOrFiniteSets) {
  constexpr std::string_view letters = "0123456789.-+eE ,\"#{}[]:xnaif\t\r\n\xff";
  for (std::uint64_t seed = 0; seed < 6000; ++seed) {
    SCOPED_TRACE(seed);
    RandomBits random(seed);
    std::string text = seed % 2 == 0 ? csv : json;
    for (std::uint64_t changes = 1 + random() % 6; changes > 0; --changes) {
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0)
        text.erase(at, 1 + random() % 9);
      else if (random() % 3 == 0)
        text.insert(at, text.substr(random() % text.size(), random() % 30));
      else
        text[at] = letters[random() % letters.size()];
      if (text.empty()) text = " ";
    }
    FeatureLog module = log(text, seed % 4 < 2);
    play(module, path_.string());
    if (HasFailure()) break;
  }
}

}  // namespace
}  // namespace ilss
