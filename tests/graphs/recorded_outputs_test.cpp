// Every payload that ships, and every output of the graphs that ship, comes back from its recording
// bit for bit.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "framework/graph/system.h"
#include "framework/record/codec.h"
#include "sensors/register.h"
#include "tests/framework/record/random_outputs.h"

namespace ilss {
namespace {

const Registry& registry() {
  static const Registry& all = *[] {
    auto* made = new Registry;
    register_sensors(*made);
    return made;
  }();
  return all;
}

/// Of all inputs and outputs of all module types.
std::vector<const PayloadDescriptor*> shipped_payloads() {
  std::set<const PayloadDescriptor*> payloads;
  for (const ModuleType* type : registry().types()) {
    const Interface interface = type->interface(Settings{});
    for (const InputDeclaration& input : interface.inputs) payloads.insert(input.payload);
    payloads.insert(interface.output);
  }
  payloads.erase(&any_payload());
  return {payloads.begin(), payloads.end()};
}

/// Writes an output, reads it with what a program of its own would know, and compares.
void expect_round_trip(const Codec& writer, const Codec& reader, const Output& output) {
  Bytes bytes;
  writer.encode({}, output, bytes);
  Outcome<> outcome = Pending{};
  Output read;
  const Outcome<> decoded = reader.decode(bytes, outcome, read);
  ASSERT_TRUE(decoded) << decoded.fault().message;
  ASSERT_TRUE(outcome);
  test::expect_same(output, read);
}

TEST(RecordedOutputs, OfEveryPayloadThatShipsComeBackBitForBit) {
  const std::uint64_t seed = 4;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  const std::vector<const PayloadDescriptor*> payloads = shipped_payloads();
  EXPECT_GT(payloads.size(), 15U);
  constexpr std::uint32_t owners = 9;
  const Codec writer(SourceOwners(owners), payloads);
  const Outcome<Codec> stranger = Codec::read_header(writer.header());
  ASSERT_TRUE(stranger) << stranger.fault().message;
  const Outcome<Codec> friendly = Codec::read_header(
      writer.header(), [](std::string_view name) { return registry().find_payload(name); });
  ASSERT_TRUE(friendly) << friendly.fault().message;
  test::RandomOutputs random(seed, owners);
  for (const PayloadDescriptor* payload : payloads) {
    SCOPED_TRACE(payload->name);
    EXPECT_EQ(std::count(friendly->payloads().begin(), friendly->payloads().end(), payload), 1);
    for (int i = 0; i < 30; ++i) {
      const Output output = random.of(*payload);
      expect_round_trip(writer, *stranger, output);
      expect_round_trip(writer, *friendly, output);
    }
  }
}

TEST(RecordedOutputs, OfTheGraphsThatShipComeBackBitForBit) {
  int recorded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ILSS_SOURCE_DIR "/graphs")) {
    const std::string file = entry.path().filename().string();
    if (!file.ends_with(".yaml") || file.ends_with(".study.yaml")) continue;
    SCOPED_TRACE(file);
    Diagnostics diagnostics;
    const auto plan = read_plan(entry.path(), registry(), {}, diagnostics);
    ASSERT_TRUE(plan);
    std::vector<const PayloadDescriptor*> payloads;
    for (const PlanNode& node : plan->nodes) payloads.push_back(node.interface.output);
    const Codec writer(plan->owners, payloads);
    const Outcome<Codec> reader = Codec::read_header(writer.header());
    ASSERT_TRUE(reader) << reader.fault().message;
    System system(*plan, 1);
    for (int tick = 0; tick < 4; ++tick) {
      system.evaluate(time_at(0.1 * tick));
      for (std::size_t i = 0; i < system.size(); ++i) {
        if (!system.node(i).outcome.has_output()) continue;
        SCOPED_TRACE(plan->nodes[i].name);
        expect_round_trip(writer, *reader, system.node(i).output());
        ++recorded;
      }
    }
  }
  EXPECT_GT(recorded, 200);
}

}  // namespace
}  // namespace ilss
