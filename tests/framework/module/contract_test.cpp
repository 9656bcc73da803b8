// What every output is held to.
#include "framework/module/contract.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "framework/module/sample_rows.h"

namespace ilss {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

inline constexpr std::string_view corner_sides[] = {"left", "right"};
inline constexpr LabelField corner_sides_labels[] = {{"side", corner_sides}};

template <typename T>
struct CheckedPlace {
  T x, z;
  std::array<int, 1> label{};
  static constexpr std::string_view name = "contract_place";
  static constexpr auto fields = Fields{{"x", "m"}, {"z", "m"}};
  static constexpr std::span<const LabelField> labels = corner_sides_labels;
};

struct Beam {
  double range = 0;
  float slope = 0;
  float echo = 0;
  static constexpr auto columns =
      Columns{column(&Beam::range, "range", "m"), column(&Beam::slope, "slope", "1"),
              column(&Beam::echo, "echo", "1", "", Missing::allowed)};
};
template <typename T>
struct CheckedScan {
  T noise;
  static constexpr std::string_view name = "contract_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<Beam>("beam"); }
};
struct PlainBeam {
  double bearing = 0;
  double range = 0;
  static constexpr auto columns = Columns{column(&PlainBeam::bearing, "bearing", "rad"),
                                          column(&PlainBeam::range, "range", "m")};
};
template <typename T>
struct PlainCheckedScan {
  T noise;
  static constexpr std::string_view name = "contract_plain_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<PlainBeam>("beam"); }
};
template <typename T>
struct CheckedPlaces {
  T count;
  static constexpr std::string_view name = "contract_places";
  static constexpr auto fields = Fields{{"count", "1"}};
  static constexpr std::string_view element = "contract_place";
  static std::vector<const PayloadDescriptor*> elements() { return {&descriptor<CheckedPlace>()}; }
};

template <template <typename> class Payload>
Output output_of() {
  Output output;
  output.estimate = Estimate(descriptor<Payload>());
  return output;
}
Output scan() {
  Output output = output_of<CheckedScan>();
  for (Beam& beam : make_rows<Beam>(output, 20)) beam = {1, 2, std::nanf("")};
  return output;
}
Output plain_scan() {
  Output output = output_of<PlainCheckedScan>();
  for (PlainBeam& beam : make_rows<PlainBeam>(output, 21)) beam = {1, 2};
  return output;
}
Output places() {
  Output output = output_of<CheckedPlaces>();
  for (int i = 0; i < 3; ++i) output.elements.push_back(Estimate(descriptor<CheckedPlace>()));
  return output;
}

Breach breach_of(const Output& output) { return find_breach(output, *output.estimate.type); }
std::string message(const Output& output) {
  return describe_breach(output, *output.estimate.type).message;
}

TEST(Contract, IsKeptByOutputsAsTheirPayloadsDeclareThem) {
  EXPECT_EQ(breach_of(scan()), Breach::none);
  EXPECT_EQ(breach_of(plain_scan()), Breach::none);
  EXPECT_EQ(breach_of(places()), Breach::none);
  EXPECT_EQ(breach_of(output_of<CheckedScan>()), Breach::none) << "samples may be absent";
}

TEST(Contract, ASampleThatIsNotFiniteIsABreachWhereverItStands) {
  for (std::size_t i = 0; i < 21; ++i)
    for (const double bad : {nan, double(INFINITY)}) {
      Output output = plain_scan();
      make_rows<PlainBeam>(output, 21)[i].range = bad;
      EXPECT_EQ(breach_of(output), Breach::not_finite) << i;
      EXPECT_EQ(message(output), "a sample's range is not finite");
    }
  for (std::size_t i = 0; i < 20; ++i) {
    Output output = scan();
    make_rows<Beam>(output, 20)[i].slope = -INFINITY;
    EXPECT_EQ(breach_of(output), Breach::not_finite) << i;
    EXPECT_EQ(message(output), "a sample's slope is not finite");
  }
}

TEST(Contract, AStandardDeviationOfSamplesThatIsNotFiniteIsABreach) {
  Output output = scan();
  output.samples.standard_deviations = {nan};
  EXPECT_EQ(breach_of(output), Breach::not_finite);
  EXPECT_EQ(message(output), "a standard deviation of the samples is not finite");
}

TEST(Contract, SamplesOfAnotherShapeAreABreach) {
  const std::vector<std::function<void(Output&)>> changes = {
      [](Output& o) { o.samples.bytes.pop_back(); },
      [](Output& o) {
        o.samples.shape = {20, 1};
      },
      [](Output& o) { o.samples.shape = {21}; }, [](Output& o) { o.samples.shape.clear(); },
      [](Output& o) { o.samples.standard_deviations.assign(2, 0.1); }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Output output = scan();
    changes[i](output);
    EXPECT_EQ(breach_of(output), Breach::other_shape) << i;
    EXPECT_EQ(message(output), "the output has other samples than contract_scan declares");
  }
  Output output = places();
  output.samples = scan().samples;
  EXPECT_EQ(breach_of(output), Breach::other_shape) << "of a payload without samples";
}

TEST(Contract, AnElementThatIsNotFiniteIsABreach) {
  Output output = places();
  output.elements[1].value[1] = nan;
  EXPECT_EQ(breach_of(output), Breach::not_finite);
  EXPECT_EQ(message(output), "element 2 (contract_place): a value or its error is not finite");
  output = places();
  output.elements[2].lineage.add({1, 0, 0}, 0, INFINITY);
  EXPECT_EQ(breach_of(output), Breach::not_finite);
}

TEST(Contract, AnElementThatItsSetDoesNotDeclareIsABreach) {
  const std::vector<std::function<void(Output&)>> changes = {
      [](Output& o) { o.elements[0].type = nullptr; },
      [](Output& o) { o.elements[0] = Estimate(descriptor<CheckedPlaces>()); },
      [](Output& o) { o.elements[0].value.pop_back(); },
      [](Output& o) { o.elements[0].lineage.reset(1); },
      [](Output& o) { o.elements[0].labels.clear(); },
      [](Output& o) { o.elements[0].labels[0] = 2; },
      [](Output& o) { o.elements[0].labels[0] = -1; }};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Output output = places();
    changes[i](output);
    EXPECT_EQ(breach_of(output), Breach::other_shape) << i;
  }
  Output output = scan();
  output.elements.push_back(Estimate(descriptor<CheckedPlace>()));
  EXPECT_EQ(breach_of(output), Breach::other_shape) << "of a payload that is no set";
}

}  // namespace
}  // namespace ilss
