// Columns of samples by their names.
#include "framework/module/column_numbers.h"

#include <gtest/gtest.h>

#include "framework/module/sample_rows.h"

namespace ilss {
namespace {

#pragma pack(push, 1)
struct Pixel {
  std::array<std::uint8_t, 3> colour = {};
  std::uint16_t depth = 0;
  float gain = 0;
  double time = 0;

  static constexpr auto columns =
      Columns{column(&Pixel::colour, "colour", "1"), column(&Pixel::depth, "depth", "1"),
              column(&Pixel::gain, "gain", "1"), column(&Pixel::time, "time", "s")};
};
#pragma pack(pop)

template <typename T>
struct Pixels {
  T exposure;
  static constexpr std::string_view name = "pixels";
  static constexpr auto fields = Fields{{"exposure", "s"}};
  static SamplesDescriptor samples() { return samples_of_rows<Pixel>("pixel"); }
};

Output two_pixels() {
  Output output;
  output.estimate = Estimate(descriptor<Pixels>(), "");
  const std::span<Pixel> rows = make_rows<Pixel>(output, 2);
  rows[0] = {{1, 2, 3}, 400, 0.5F, 0.25};
  rows[1] = {{250, 5, 6}, 65535, -1.5F, 1e100};
  return output;
}

TEST(ColumnNumbers, AreWhatTheRowsHoldWhateverTheirType) {
  const Output output = two_pixels();
  const auto numbers = [&](const char* column) {
    const auto found = ColumnNumbers::find(output, column);
    EXPECT_TRUE(found) << column;
    std::vector<double> values;
    for (std::size_t i = 0; found && i < found->size(); ++i) values.push_back((*found)[i]);
    return values;
  };
  EXPECT_EQ(numbers("colour"), (std::vector<double>{1, 250})) << "the first of three";
  EXPECT_EQ(numbers("depth"), (std::vector<double>{400, 65535}));
  EXPECT_EQ(numbers("gain"), (std::vector<double>{0.5, -1.5}));
  EXPECT_EQ(numbers("time"), (std::vector<double>{0.25, 1e100}));
}

TEST(ColumnNumbers, ThereAreNoneOfAColumnThatThePayloadHasNot) {
  EXPECT_FALSE(ColumnNumbers::find(two_pixels(), "range"));
}

TEST(ColumnNumbers, AnOutputWithoutSamplesHasNone) {
  Output output = two_pixels();
  output.samples.bytes.clear();
  const auto numbers = ColumnNumbers::find(output, "time");
  ASSERT_TRUE(numbers);
  EXPECT_EQ(numbers->size(), 0U);
}

}  // namespace
}  // namespace ilss
