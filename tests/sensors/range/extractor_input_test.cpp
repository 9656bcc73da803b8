// What both extractors say to readings that cannot be, and that no number they give is not one.
#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "sensors/range/ekf_line_extractor.h"
#include "tests/sensors/features/feature_run.h"
#include "tests/sensors/range/scans.h"

namespace ilss {
namespace {

class ExtractorInput : public ::testing::TestWithParam<bool> {
 protected:
  std::unique_ptr<Module> module() const {
    if (GetParam()) return std::make_unique<EkfLineExtractor>(EkfLineExtractor::Options{});
    return std::make_unique<LineExtractor>(LineExtractor::Options{});
  }
  ModuleRun of(const Output& scan) const { return extract(*module(), scan); }
  ModuleRun of(const std::vector<RangeReading>& readings) const {
    return of(scan_output(readings));
  }
  static std::vector<RangeReading> good(std::size_t count = 64, unsigned seed = 241) {
    std::mt19937_64 random(seed);
    ScanOf scan;
    scan.readings = count;
    return scan.on(on_line(polar_line(1.2, 1.5)), random);
  }
};

TEST_P(ExtractorInput, IsRefusedWhereAReadingCannotBe) {
  const std::vector<std::pair<const char*, std::function<void(RangeReading&)>>> mistakes = {
      {"range NaN", [](RangeReading& r) { r.inverse_range = NAN; }},
      {"range infinite", [](RangeReading& r) { r.inverse_range = 0; }},
      {"range zero", [](RangeReading& r) { r.inverse_range = INFINITY; }},
      {"range negative", [](RangeReading& r) { r.inverse_range = -1; }},
      {"sd zero", [](RangeReading& r) { r.deviation = 0; }},
      {"sd negative", [](RangeReading& r) { r.deviation = -0.01; }},
      {"sd NaN", [](RangeReading& r) { r.deviation = NAN; }},
      {"sd infinite", [](RangeReading& r) { r.deviation = INFINITY; }},
      {"bearing NaN", [](RangeReading& r) { r.bearing = NAN; }},
      {"origin NaN", [](RangeReading& r) { r.origin_z = NAN; }},
      {"head infinite", [](RangeReading& r) { r.head = INFINITY; }},
      {"time NaN", [](RangeReading& r) { r.time = NAN; }},
      {"sensitivity NaN", [](RangeReading& r) { r.sensitivity[2] = NAN; }},
      {"bearing back", [](RangeReading& r) { r.bearing += 0.1; }},
      {"bearing far on", [](RangeReading& r) { r.bearing -= 0.1; }}};
  for (const auto& [name, mistake] : mistakes) {
    auto readings = good();
    mistake(readings[30]);
    const ModuleRun result = of(readings);
    ASSERT_EQ(fault_of(result.outcome), "bad_data") << name;
    EXPECT_NE(result.outcome.fault().message.find("reading 3"), std::string::npos)
        << name << ": " << result.outcome.fault().message;
  }
  auto twice = good();
  twice[30].bearing = twice[29].bearing;
  EXPECT_EQ(fault_of(of(twice).outcome), "bad_data");
}

TEST_P(ExtractorInput, NeedsAsManyReadingsAsASegment) {
  for (const std::size_t count : {0, 1, 2, 4}) {
    auto readings = good();
    readings.resize(count);
    EXPECT_EQ(fault_of(of(readings).outcome), "no_detection") << count;
  }
  auto five = good();
  five.resize(5);
  const ModuleRun result = of(five);
  ASSERT_TRUE(result.outcome);
  EXPECT_TRUE(all_finite(result.output));
}

TEST_P(ExtractorInput, MayBeReadingsOnOneRangeInIdenticalDirections) {
  auto readings = good();
  for (RangeReading& r : readings) r.bearing = 1.5;
  EXPECT_EQ(fault_of(of(readings).outcome), "bad_data");
}

TEST_P(ExtractorInput, MayBeAHundredThousandReadings) {
  const Surface a = on_line(polar_line(1.2, 1.5));
  const Surface b = on_line(polar_line(1.8, 1.6));
  for (const std::size_t count : {10000, 100000}) {
    std::mt19937_64 random(242);
    ScanOf scan;
    scan.readings = count;
    const ModuleRun result =
        of(scan.on([&](std::size_t i) -> const Surface& { return i < count / 2 ? a : b; }, random));
    ASSERT_TRUE(result.outcome);
    EXPECT_TRUE(all_finite(result.output));
    if (!GetParam() && count == 10000) {
      EXPECT_EQ(segments_of(result.output).size(), 2u);
    }
  }
}

TEST_P(ExtractorInput, MayBeReadingsOfNoSurface) {
  std::mt19937_64 random(243);
  std::size_t segments = 0;
  for (int run = 0; run < 200; ++run) {
    auto readings = good();
    for (RangeReading& r : readings)
      r.inverse_range = std::uniform_real_distribution<double>(0.2, 3)(random);
    const ModuleRun result = of(readings);
    ASSERT_TRUE(result.outcome);
    EXPECT_TRUE(all_finite(result.output));
    segments += segments_of(result.output).size();
  }
  if (!GetParam()) {
    EXPECT_LE(segments, 8u) << "but for five in a row by chance, outliers are no segments";
  }
}

TEST_P(ExtractorInput, MayBeExactOnALine) {
  const Surface line = on_line(polar_line(1.2, 1.5));
  auto readings = good();
  for (RangeReading& r : readings) r.inverse_range = line(r);
  const ModuleRun result = of(readings);
  ASSERT_TRUE(result.outcome);
  EXPECT_TRUE(all_finite(result.output));
  ASSERT_EQ(segments_of(result.output).size(), 1u);
  EXPECT_NEAR(segments_of(result.output)[0]->value[0], 1.2, 1e-9);
}

// Extreme but possible numbers, and lines that run through the origin.
TEST_P(ExtractorInput, MayBeExtremeAndStillGivesNumbers) {
  constexpr unsigned seed = 244;
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const auto any = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random));
  };
  for (int run = 0; run < 2000; ++run) {
    auto readings = good(16 + static_cast<std::size_t>(run % 50));
    const double range_scale = any(1e-6, 1e6);
    const double deviation_scale = any(1e-6, 1e6);
    const double angle_scale = any(1e-5, 4);
    for (RangeReading& r : readings) {
      r.inverse_range *= range_scale * (run % 3 == 0 ? any(0.1, 10) : 1);
      r.deviation *= deviation_scale * (run % 5 == 0 ? any(0.01, 100) : 1);
      r.bearing = 1.5 + (r.bearing - 1.5) * angle_scale;
      if (run % 7 == 0) r.origin_x = any(0.01, 10);
    }
    const ModuleRun result = of(readings);
    if (result.outcome) {
      ASSERT_TRUE(all_finite(result.output)) << "run " << run;
    }
  }
}

// The published filter does not use the noise's correlation.
TEST(LineExtractorInput, RefusesACorrelationOfNoiseThatCannotBe) {
  for (const double r : {1.0, 1.5, -0.1, -1.0, double(NAN)}) {
    std::mt19937_64 random(245);
    Output scan = scan_output(ScanOf{}.on(on_line(polar_line(1.2, 1.5)), random));
    LineExtractor extractor({});
    scan.estimate.value[8] = r;
    EXPECT_EQ(fault_of(extract(extractor, scan).outcome), "bad_data") << r;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, ExtractorInput, ::testing::Bool(), [](const auto& of) {
  return of.param ? "EkfLineExtractor" : "LineExtractor";
});

}  // namespace
}  // namespace ilss
