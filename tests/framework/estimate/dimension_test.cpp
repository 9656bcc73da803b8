#include "framework/estimate/dimension.h"

#include <gtest/gtest.h>

namespace ilss {
namespace {

TEST(Dimension, IsOfAUnitWhateverItsScale) {
  EXPECT_EQ(Dimension::of("nm"), Dimension::of("km"));
  EXPECT_EQ(Dimension::of("degC"), Dimension::of("K"));
  EXPECT_EQ(Dimension::of("N.m"), Dimension::of("J"));
  EXPECT_EQ(Dimension::of("um/m"), Dimension());
}

TEST(Dimension, OfUnknownUnitIsNone) {
  EXPECT_FALSE(Dimension::of("parrots"));
  EXPECT_FALSE(Dimension::of("dB"));
}

TEST(Dimension, CountsAngleAsADimension) {
  EXPECT_EQ(Dimension::of("deg"), Dimension::angle());
  EXPECT_NE(Dimension::of("rad/s"), Dimension::of("Hz"));
  EXPECT_NE(Dimension::of("1"), Dimension::angle());
}

TEST(Dimension, ProductsAddPowers) {
  const Dimension length = *Dimension::of("m");
  const Dimension time = *Dimension::of("s");
  EXPECT_EQ(length / time * *Dimension::of("kg") / time, *Dimension::of("N"));
  EXPECT_EQ(length.power(2), *Dimension::of("m2"));
  EXPECT_TRUE((length / length).is_pure_number());
}

TEST(Dimension, RootsUndoPowersThoughTheyRound) {
  const Dimension length = *Dimension::of("m");
  EXPECT_EQ(length.power(0.5).power(2), length);
  EXPECT_EQ(length.power(0.1).power(0.7).power(1 / 0.07), length);
  EXPECT_NE(length.power(0.5), length);
}

TEST(Dimension, UnitReadsBackAsTheSame) {
  for (const char* unit : {"m", "m/s", "kg.m2/s2", "1/K", "rad/s", "m/rad", "A.s", "cd.rad2", "1"})
    EXPECT_EQ(Dimension::of(Dimension::of(unit)->unit()), Dimension::of(unit)) << unit;
  EXPECT_EQ(Dimension::of("N")->unit(), "kg.m/s2");
  EXPECT_EQ(Dimension::of("m")->power(0.5).unit(), "m^0.5");
}

TEST(Dimension, NamesAreForPeople) {
  EXPECT_EQ(Dimension::of("nm")->name(), "a length (m)");
  EXPECT_EQ(Dimension::of("km/h")->name(), "a speed (m/s)");
  EXPECT_EQ(Dimension().name(), "a pure number");
}

}  // namespace
}  // namespace ilss
