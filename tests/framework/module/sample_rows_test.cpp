// Samples as rows: what a row's struct declares is checked against its layout and its payload.
#include "framework/module/sample_rows.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace ilss {
namespace {

struct Beam {
  double range = 1;
  std::array<float, 2> slope = {};
  std::uint16_t echo = 0;
  std::array<std::uint8_t, 6> colour = {};

  static constexpr auto columns =
      Columns{column(&Beam::range, "range", "m", "0: none"),
              column(&Beam::slope, "slope", "1", "of the surface", Missing::allowed),
              column(&Beam::echo, "echo", "1"), column(&Beam::colour, "colour", "1")};
};
static_assert(SampleRow<Beam>);

struct Exchanged {
  double a = 0, b = 0;
  static constexpr auto columns =
      Columns{column(&Exchanged::b, "b", "m"), column(&Exchanged::a, "a", "m")};
};
static_assert(!SampleRow<Exchanged>, "columns stand in the members' order");

struct Forgotten {
  double a = 0, b = 0;
  static constexpr auto columns = Columns{column(&Forgotten::a, "a", "m")};
};
static_assert(!SampleRow<Forgotten>, "every member is a column");

struct Twice {
  double a = 0, b = 0;
  static constexpr auto columns = Columns{column(&Twice::a, "a", "m"), column(&Twice::a, "a", "m")};
};
static_assert(!SampleRow<Twice>, "no member is a column twice");

struct Padded {
  double a = 0;
  float b = 0;
  static constexpr auto columns =
      Columns{column(&Padded::a, "a", "m"), column(&Padded::b, "b", "m")};
};
static_assert(!SampleRow<Padded>, "a row has no bytes that are in no column");

template <typename T>
struct EchoScan {
  T noise;
  static constexpr std::string_view name = "rows_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<Beam>("beam"); }
};

struct OtherBeam {
  double range = 0;
  std::array<double, 2> slope = {};
  static constexpr auto columns =
      Columns{column(&OtherBeam::range, "range", "m"), column(&OtherBeam::slope, "slope", "1")};
};

Output echo_scan() {
  Output output;
  output.estimate = Estimate(descriptor<EchoScan>());
  return output;
}

TEST(SampleRows, ArePartOfThePayload) {
  const SamplesDescriptor& samples = *descriptor<EchoScan>().samples;
  EXPECT_EQ(samples.axes, std::vector<std::string>{"beam"});
  EXPECT_EQ(samples.bytes(), sizeof(Beam));
  ASSERT_EQ(samples.columns.size(), 4u);
  EXPECT_EQ(samples.columns[0].documentation, "0: none");
  EXPECT_EQ(samples.columns[1].type, SampleType::float32);
  EXPECT_EQ(samples.columns[1].count, 2u);
  EXPECT_TRUE(samples.columns[1].may_be_missing);
  EXPECT_EQ(samples.columns[2].type, SampleType::uint16);
  EXPECT_EQ(samples.columns[3].count, 6u);
}

TEST(SampleRows, AreReadAsTheyWereWritten) {
  Output output = echo_scan();
  const std::span<Beam> written = make_rows<Beam>(output, 3);
  for (std::size_t i = 0; i < written.size(); ++i)
    written[i] = {1.5 * static_cast<double>(i), {0.25f, 2}, 7, {1, 2, 3, 4, 5, 6}};
  EXPECT_EQ(output.samples.shape, std::vector<std::size_t>{3});
  const Output copy = output;
  const std::span<const Beam> read = rows_of<Beam>(copy);
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[2].range, 3);
  EXPECT_EQ(read[2].colour[5], 6);
}

TEST(SampleRows, ThatAreThereStayWhenThereAreFewer) {
  Output output = echo_scan();
  make_rows<Beam>(output, 3)[1].range = 8;
  EXPECT_EQ(make_rows<Beam>(output, 2)[1].range, 8);
}

TEST(SampleRows, OfAnotherLayoutThanThePayloadsAreRefused) {
  Output output = echo_scan();
  EXPECT_THROW((void)make_rows<OtherBeam>(output, 3), std::logic_error);
  make_rows<Beam>(output, 3);
  EXPECT_THROW((void)rows_of<OtherBeam>(output), std::logic_error);
  EXPECT_THROW((void)rows_of<std::uint8_t>(output), std::logic_error);
}

TEST(SampleRows, ThatAreCutAreRefused) {
  Output output = echo_scan();
  make_rows<Beam>(output, 3);
  output.samples.bytes.pop_back();
  EXPECT_THROW((void)rows_of<Beam>(output), std::logic_error);
}

TEST(IndexOf, IsAComponentsPlace) { static_assert(index_of<EchoScan>("noise") == 0); }

TEST(Elements, KeepTheBuffersOfThoseThatTheyLose) {
  Elements elements(std::initializer_list<Estimate>{Estimate(descriptor<EchoScan>(), "frame"),
                                                    Estimate(descriptor<EchoScan>(), "frame")});
  const double* const buffer = elements[1].value.data();
  elements.resize(1);
  elements.resize(2);
  elements[1].value.assign(1, 4.0);
  EXPECT_EQ(elements[1].value.data(), buffer);
}

TEST(Elements, ComeBackBlank) {
  Elements elements;
  Estimate& element = elements.emplace_back();
  element = Estimate(descriptor<EchoScan>(), "frame");
  element.lineage.add({1, 0, 0}, 0, 1.0);
  element.correlation_unknown = true;
  elements.clear();
  elements.resize(1);
  EXPECT_EQ(elements[0].type, nullptr);
  EXPECT_TRUE(elements[0].value.empty());
  EXPECT_TRUE(elements[0].lineage.empty());
  EXPECT_FALSE(elements[0].correlation_unknown);
}

TEST(Elements, ThatAreMovedLeaveNoneBehind) {
  Elements elements(std::initializer_list<Estimate>{Estimate(descriptor<EchoScan>())});
  const Elements taken = std::move(elements);
  EXPECT_EQ(taken.size(), 1u);
  EXPECT_EQ(elements.size(), 0u);  // NOLINT(bugprone-use-after-move): what is tested
}

}  // namespace
}  // namespace ilss
