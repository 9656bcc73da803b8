// Outputs as bytes and back: nothing is lost, and no bytes are believed.
#include "framework/record/codec.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "framework/module/contract.h"
#include "framework/module/sample_rows.h"
#include "tests/framework/record/random_outputs.h"

namespace ilss {
namespace {

inline constexpr std::string_view sides[] = {"left", "right", "both"};
inline constexpr LabelField side_labels[] = {{"side", sides}};

template <typename T>
struct Line {
  T rho, phi;
  std::array<int, 1> label{};
  static constexpr std::string_view name = "codec_line";
  static constexpr auto fields =
      Fields{{"rho", "m", "a distance", 1.5}, {"phi", "rad", "", required, Geometry::circular}};
  static constexpr std::span<const LabelField> labels = side_labels;
};
template <typename T>
struct Corner {
  T x, z;
  static constexpr std::string_view name = "codec_corner";
  static constexpr auto fields = Fields{{"x", "m"}, {"z", "m"}};
};
template <typename T>
struct Features {
  T count;
  static constexpr std::string_view name = "codec_features";
  static constexpr auto fields = Fields{{"count", "1"}};
  static constexpr std::string_view element = "codec_line or codec_corner";
  static std::vector<const PayloadDescriptor*> elements() {
    return {&descriptor<Line>(), &descriptor<Corner>()};
  }
};
struct Beam {
  double range = 0;
  std::array<float, 2> slope = {};
  std::uint16_t echo = 0;
  std::array<std::uint8_t, 6> colour = {};
  static constexpr auto columns =
      Columns{column(&Beam::range, "range", "m", "0: none", Missing::allowed),
              column(&Beam::slope, "slope", "1", "of the surface"),
              column(&Beam::echo, "echo", "1"), column(&Beam::colour, "colour", "1")};
};
template <typename T>
struct Scan {
  T noise;
  static constexpr std::string_view name = "codec_scan";
  static constexpr std::string_view documentation = "for tests";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<Beam>("beam"); }
};
template <typename T>
struct OtherScan {
  T noise;
  static constexpr std::string_view name = "codec_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
};

constexpr std::uint32_t owner_count = 40;

SourceOwners owners() {
  SourceOwners owners(owner_count);
  for (std::size_t i = 0; i < owners.size(); ++i) {
    owners[i].name = "module " + std::to_string(i);
    owners[i].persistent = i % 3 == 0;
    owners[i].distribution.shape = static_cast<Shape>(i % 5);
    owners[i].distribution.degrees_of_freedom = i % 5 == 4 ? 7 : 0;
    if (i % 4 == 0) owners[i].degrees_of_freedom = 11.5;
  }
  owners[7].distribution.shape = Shape::empirical;
  owners[7].distribution.samples =
      std::make_shared<const std::vector<double>>(std::vector<double>{-1, 0.25, 1});
  return owners;
}

const std::vector<const PayloadDescriptor*>& payloads() {
  static const std::vector<const PayloadDescriptor*> all = {
      &descriptor<Features>(), &descriptor<Scan>(), &descriptor<Line>()};
  return all;
}

Codec codec() { return {owners(), payloads()}; }

/// What a header and an outcome say, read by a program that does not know the payloads.
Outcome<> read_back(const Codec& reader, const Bytes& bytes, Output& output) {
  Outcome<> outcome;
  if (Outcome<> read = reader.decode(bytes, outcome, output); !read) return read;
  return outcome;
}

TEST(Codec, HeaderGivesBackOwnersAndPayloads) {
  const Bytes header = codec().header();
  const Outcome<Codec> read = Codec::read_header(header);
  ASSERT_TRUE(read);
  const SourceOwners expected = owners();
  ASSERT_EQ(read->owners().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(read->owners()[i].name, expected[i].name);
    EXPECT_EQ(read->owners()[i].persistent, expected[i].persistent);
    EXPECT_EQ(read->owners()[i].distribution.shape, expected[i].distribution.shape);
    EXPECT_EQ(read->owners()[i].degrees_of_freedom, expected[i].degrees_of_freedom);
  }
  EXPECT_EQ(*read->owners()[7].distribution.samples, *expected[7].distribution.samples);
  ASSERT_EQ(read->payloads().size(), 4u) << "the elements' payloads are added by themselves";
  for (const PayloadDescriptor* payload : payloads())
    EXPECT_TRUE(std::any_of(read->payloads().begin(), read->payloads().end(),
                            [&](const auto* other) { return same_payload(*payload, *other); }))
        << payload->name;
  EXPECT_EQ(read->payloads().back()->samples->columns[0].documentation, "0: none");
  EXPECT_EQ(read->header(), header);
}

TEST(Codec, HeaderTakesTheProgramsOwnPayloads) {
  const auto find = [](std::string_view name) {
    return name == "codec_scan" ? &descriptor<Scan>() : nullptr;
  };
  const Outcome<Codec> read = Codec::read_header(codec().header(), find);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->payloads().back(), &descriptor<Scan>());
}

TEST(Codec, HeaderOfAPayloadThatIsOtherwiseHereIsBadData) {
  const auto find = [](std::string_view name) {
    return name == "codec_scan" ? &descriptor<OtherScan>() : nullptr;
  };
  const Outcome<Codec> read = Codec::read_header(codec().header(), find);
  ASSERT_TRUE(read.is_fault());
  EXPECT_EQ(read.fault().kind, FaultKind::bad_data);
  EXPECT_EQ(read.fault().message,
            "payload 'codec_scan' was recorded with other components, labels, samples or elements "
            "than it has here");
}

TEST(Codec, OfTwoPayloadsOfOneNameIsRefused) {
  const std::vector<const PayloadDescriptor*> two = {&descriptor<Scan>(), &descriptor<OtherScan>()};
  EXPECT_THROW(Codec(owners(), two), std::invalid_argument);
}

TEST(Codec, GivesOutputsBackBitForBit) {
  const std::uint64_t seed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  test::RandomOutputs random(seed, owner_count);
  const Codec writer = codec();
  const Outcome<Codec> reader = Codec::read_header(writer.header());
  ASSERT_TRUE(reader);
  Output read;
  for (int i = 0; i < 3000; ++i) {
    const Output output = random.of(*payloads()[random.below(payloads().size())]);
    Bytes bytes;
    writer.encode({}, output, bytes);
    ASSERT_TRUE(read_back(*reader, bytes, read)) << i;
    test::expect_same(output, read);
    Bytes again;
    reader->encode({}, read, again);
    ASSERT_EQ(again, bytes) << i;
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Codec, GivesFaultsAndPendingBack) {
  const Codec both = codec();
  Output unused;
  Bytes bytes;
  both.encode(Fault{FaultKind::device_lost, "no \"scanner\"\n"}, unused, bytes);
  const Outcome<> fault = read_back(both, bytes, unused);
  ASSERT_TRUE(fault.is_fault());
  EXPECT_EQ(fault.fault().kind, FaultKind::device_lost);
  EXPECT_EQ(fault.fault().message, "no \"scanner\"\n");
  bytes.clear();
  both.encode(Pending{}, unused, bytes);
  EXPECT_TRUE(read_back(both, bytes, unused).is_pending());
}

/// A corner on a line: both hold the line's two sources, and the mount's.
Output corner_on_line(std::size_t corners) {
  Output output;
  output.estimate = Estimate(descriptor<Features>(), "robot");
  Estimate line(descriptor<Line>(), "robot");
  Estimate corner(descriptor<Corner>(), "robot");
  for (const Source& source : {Source{3, 0, 5}, Source{3, 1, 5}, Source{9, 0, persistent_tick}}) {
    line.lineage.add(source, std::vector{0.01, 0.002});
    corner.lineage.add(source, std::vector{0.02, -0.01});
  }
  output.elements.push_back(line);
  for (std::size_t i = 0; i < corners; ++i) output.elements.push_back(corner);
  return output;
}

TEST(Codec, ACornerStaysCorrelatedWithItsLine) {
  const Output output = corner_on_line(1);
  const Codec both = codec();
  Bytes bytes;
  both.encode({}, output, bytes);
  Output read;
  ASSERT_TRUE(read_back(both, bytes, read));
  const auto between = [](const Output& set) {
    return cross_covariance(set.elements[0].lineage, set.elements[1].lineage);
  };
  EXPECT_EQ(between(read), between(output));
  EXPECT_FALSE(between(read).isZero());
}

TEST(Codec, WritesCommonSourcesOnce) {
  const auto size = [](std::size_t corners) {
    Bytes bytes;
    codec().encode({}, corner_on_line(corners), bytes);
    return bytes.size();
  };
  constexpr std::size_t flags_and_payload = 5;
  constexpr std::size_t values_and_factor = (2 + 2 * 3) * sizeof(double);
  EXPECT_EQ(size(11) - size(10), flags_and_payload + values_and_factor);
}

TEST(Codec, RefusesWhatItsHeaderHasNot) {
  const Codec narrow(SourceOwners(2), std::vector<const PayloadDescriptor*>{&descriptor<Line>()});
  Bytes bytes;
  Output output;
  output.estimate = Estimate(descriptor<Corner>(), "robot");
  EXPECT_THROW(narrow.encode({}, output, bytes), std::invalid_argument);
  output.estimate = Estimate(descriptor<Line>(), "robot");
  output.estimate.lineage.add({2, 0, 0}, 0, 1.0);
  EXPECT_THROW(narrow.encode({}, output, bytes), std::invalid_argument);
}

TEST(Codec, RefusesAnOutputThatBreaksItsContract) {
  Output output = corner_on_line(1);
  output.elements[0].value[0] = std::numeric_limits<double>::quiet_NaN();
  Bytes bytes;
  EXPECT_THROW(codec().encode({}, output, bytes), std::invalid_argument);
}

TEST(Codec, BytesThatAreCutOrGoOnAreBadData) {
  const Codec both = codec();
  Bytes bytes;
  both.encode({}, corner_on_line(2), bytes);
  Output read;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const Outcome<> outcome =
        read_back(both, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)}, read);
    ASSERT_TRUE(outcome.is_fault()) << length;
    EXPECT_EQ(outcome.fault().kind, FaultKind::bad_data);
  }
  bytes.push_back(std::byte{0});
  EXPECT_TRUE(read_back(both, bytes, read).is_fault());
}

/// Changes, cuts, doubles or moves a few bytes.
void mutate(Bytes& bytes, test::RandomOutputs& random) {
  for (std::size_t n = 1 + random.below(6); n > 0 && !bytes.empty(); --n) {
    const auto at = static_cast<std::ptrdiff_t>(random.below(bytes.size()));
    switch (random.below(8)) {
      case 0:
        bytes.resize(static_cast<std::size_t>(at));
        break;
      case 1:
        bytes.insert(bytes.begin() + at, std::byte{0xff});
        break;
      case 2:
        bytes.erase(bytes.begin() + at);
        break;
      case 3:
        bytes[static_cast<std::size_t>(at)] = std::byte{0xff};
        break;
      case 4:
        bytes[static_cast<std::size_t>(at)] ^= static_cast<std::byte>(1u << random.below(8));
        break;
      default:
        bytes[static_cast<std::size_t>(at)] = static_cast<std::byte>(random.below(256));
    }
  }
}

TEST(Codec, OfMutatedBytesGivesAnErrorOrAnOutputThatKeepsItsContract) {
  const std::uint64_t seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  test::RandomOutputs random(seed, owner_count);
  const Codec both = codec();
  std::vector<Bytes> originals(300);
  for (Bytes& original : originals)
    both.encode({}, random.of(*payloads()[random.below(payloads().size())]), original);
  Output read;
  Outcome<> outcome;
  int errors = 0;
  constexpr int tries = 900'000;
  for (int i = 0; i < tries; ++i) {
    Bytes bytes = originals[random.below(originals.size())];
    mutate(bytes, random);
    const Outcome<> decoded = both.decode(bytes, outcome, read);
    errors += decoded ? 0 : 1;
    if (decoded && outcome.has_output()) {
      ASSERT_EQ(find_breach(read, *read.estimate.type), Breach::none) << i;
    }
  }
  EXPECT_GT(errors, tries / 10);
  EXPECT_LT(errors, tries) << "some mutations change a number only";
}

TEST(Codec, OfAMutatedHeaderGivesAnErrorOrACodecThatWorks) {
  const std::uint64_t seed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  test::RandomOutputs random(seed, owner_count);
  const Bytes original = codec().header();
  int errors = 0;
  constexpr int tries = 100'000;
  for (int i = 0; i < tries; ++i) {
    Bytes bytes = original;
    mutate(bytes, random);
    const Outcome<Codec> read = Codec::read_header(bytes);
    errors += read ? 0 : 1;
    if (read) {
      ASSERT_EQ(read->header(), bytes) << i;
    }
  }
  EXPECT_GT(errors, tries / 10);
  EXPECT_LT(errors, tries) << "some mutations change a name only";
}

}  // namespace
}  // namespace ilss
