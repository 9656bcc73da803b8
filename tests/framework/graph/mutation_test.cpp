// Graphs and values out of shape: whatever the text, reading it ends, with a plan or with messages.
#include <gtest/gtest.h>

#include <array>

#include "framework/graph/scheduled_command.h"
#include "framework/graph/value_reader.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

std::size_t draw(RandomBits& random, std::size_t below) { return random() % below; }

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Graphs of the test's modules, and the shipped ones, whose modules are unknown here: reading
/// them still goes through everything else.
std::vector<std::string> graphs() {
  std::vector<std::string> texts = {
      R"(ilss: diamond
description: two ways to the same
constants: {k: {value: 2, std: 0.1}, v: {value: {x: 1 m, y: 2 mm}, covariance: [[1, 0.5], [0.5, 1]]}}
modules:
  source: {type: reading, value: 3 m, value_std: 1 mm, noise: normal, period: 2, skipped: [4, 5]}
  up: {type: gain, gain: $k, offset: $v.x, time: {typical: 1 ms, worst: 2 ms}}
  down: {type: gain, gain: {value: 2, std: 1 %}, offset: $v.y}
  last: {type: subtract}
network:
  serial: [source, combine: {of: [up, down], max_age: 20 ms}, last]
)",
      R"(ilss: anchors
modules:
  a: {type: reading, bias: &bias {value: 1 mm, std: 2 mm}, mount: {x: *bias}, frame: here}
  b: &b {type: carry}
  c: *b
  t: {type: turn_reading, angle: -7.5 deg}
  p: {type: pair_reading, a: 1 m}
  m: {type: mix}
  z: {type: total, time: 3 us}
network:
  combine:
    - serial: [a, b]
    - serial: [a, c]
    - t
    - serial: [combine: [p, p], m]
    - serial: [combine: [a, a, a], z]
)",
      R"(ilss: commanded
modules:
  head: {type: head}
  other: {type: head}
  turn: {type: turn_reading, angle: 3 deg}
network: {combine: [head, other, turn]}
commands:
  look: head.rotate_to
  follow: {to: other.rotate_to, from: turn.angle}
  zoom: {to: other.zoom, from: head.ratio}
  mode: {to: head.mode}
)"};
  for (const char* folder : {"tests/data/graph_errors", "graphs"}) {
    const std::filesystem::path path = std::filesystem::path(ILSS_SOURCE_DIR) / folder;
    std::vector<std::filesystem::path> files;
    if (std::filesystem::exists(path))
      for (const auto& entry : std::filesystem::directory_iterator(path))
        if (entry.path().extension() == ".yaml") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const auto& file : files) texts.push_back(text_of(file));
  }
  return texts;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

void mutate_lines(std::string& text, RandomBits& random) {
  std::vector<std::string> lines = lines_of(text);
  if (lines.empty()) return;
  const std::size_t i = draw(random, lines.size());
  const std::size_t j = draw(random, lines.size());
  switch (draw(random, 4)) {
    case 0:
      std::swap(lines[i], lines[j]);
      break;
    case 1:
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(i));
      break;
    case 2:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(j), std::string(lines[i]));
      break;
    default:
      if (draw(random, 2) == 0)
        lines[i].insert(0, 1 + draw(random, 3), ' ');
      else
        lines[i].erase(0, 1 + draw(random, 3));
  }
  text = joined(lines);
}

/// Puts something in that YAML, quantities or graphs give a meaning to.
void splice(std::string& text, RandomBits& random) {
  static const std::array<std::string, 44> tokens = {"&x ",
                                                     "*x",
                                                     "*bias",
                                                     "&bias ",
                                                     "<<: *b",
                                                     "{",
                                                     "}",
                                                     "[",
                                                     "]",
                                                     ": ",
                                                     ", ",
                                                     "- ",
                                                     "|\n",
                                                     ">\n",
                                                     "!!str ",
                                                     "? ",
                                                     "---\n",
                                                     "...\n",
                                                     "%YAML 9.9\n",
                                                     "\t",
                                                     "\"",
                                                     "'",
                                                     "#",
                                                     "~",
                                                     "null",
                                                     "$k",
                                                     "$v",
                                                     "$v.x",
                                                     "$",
                                                     "1e309 m",
                                                     "-1e-400",
                                                     "9223372036854775808",
                                                     "nan",
                                                     "inf m",
                                                     "0x10",
                                                     "serial: [",
                                                     "combine: {of: ",
                                                     "select: ",
                                                     "type: {ilss: graph.yaml}",
                                                     "set: {a.b.c: 1}",
                                                     "std: ",
                                                     "value: ",
                                                     "covariance: [[1]]",
                                                     "\xc3\x28"};
  const std::size_t at = draw(random, text.size() + 1);
  switch (draw(random, 8)) {
    case 0:
      text.insert(at, std::string(1 + draw(random, 400), '['));
      break;
    case 1:
      text.insert(at, std::string(1 + draw(random, 400), '9'));
      break;
    case 2: {
      std::string deep;
      for (std::size_t n = draw(random, 250); n > 0; --n) deep += "{serial: [";
      text.insert(at, deep);
      break;
    }
    default:
      text.insert(at, tokens[draw(random, tokens.size())]);
  }
}

void mutate_bytes(std::string& text, RandomBits& random) {
  if (text.empty()) return;
  const std::size_t at = draw(random, text.size());
  switch (draw(random, 5)) {
    case 0:
      text[at] = static_cast<char>(draw(random, 256));
      break;
    case 4:
      if (const std::size_t digit = text.find_first_of("0123456789", at); digit < text.size())
        text[digit] = "0123456789.-e"[draw(random, 13)];
      break;
    case 1:
      text[at] = static_cast<char>(text[at] ^ (1 << draw(random, 8)));
      break;
    case 2:
      text.erase(at, 1 + draw(random, 12));
      break;
    default: {
      const std::size_t from = draw(random, text.size());
      text.insert(at, text.substr(from, 1 + draw(random, 20)));
    }
  }
}

std::string mutated(std::string text, RandomBits& random) {
  for (std::size_t n = 1 + draw(random, 1 + draw(random, 4)); n > 0; --n) switch (draw(random, 3)) {
      case 0:
        mutate_lines(text, random);
        break;
      case 1:
        mutate_bytes(text, random);
        break;
      default:
        splice(text, random);
    }
  return text;
}

/// Every diagnostic has a place in a file and something to say.
void expect_readable(const Diagnostics& diagnostics, const std::string& text) {
  for (const Diagnostic& d : diagnostics.sorted()) {
    ASSERT_NE(d.position.file, nullptr) << d.message << "\n" << text;
    ASSERT_FALSE(d.message.empty()) << text;
  }
}

TEST(MutatedGraphs, GiveAPlanOrMessages) {
  constexpr std::uint64_t first_seed = 1;
  constexpr int count = 20000;
  const std::vector<std::string> texts = graphs();
  constexpr std::size_t right_ones = 3;
  for (std::size_t right = 0; right < right_ones; ++right)
    ASSERT_EQ(test::read_text(texts[right]).errors, "");
  int plans = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + count; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RandomBits random(seed);
    // Half of them start from those that are right, so that plans come of some.
    const std::size_t start =
        draw(random, 2) == 0 ? draw(random, right_ones) : draw(random, texts.size());
    const std::string text = mutated(texts[start], random);
    Diagnostics diagnostics;
    std::optional<Plan> plan;
    ASSERT_NO_THROW({
      const Node graph = parse_document(text, "graph.yaml", diagnostics);
      plan = build_plan(graph, ILSS_TEST_DATA, test::registry(), {}, diagnostics);
    }) << text;
    ASSERT_TRUE(plan || !diagnostics.empty()) << text;
    expect_readable(diagnostics, text);
    if (HasFatalFailure()) return;
    if (!plan || !diagnostics.empty()) continue;
    ++plans;
    ASSERT_NO_THROW({
      System system(*plan, seed);
      system.expect();
      system.evaluate(time_at(0));
    }) << text;
  }
  EXPECT_GT(plans, count / 50);
}

TEST(MutatedValues, GiveAValueOrMessages) {
  constexpr std::uint64_t first_seed = 1;
  constexpr int count = 5000;
  const std::array<std::string, 6> texts = {
      "{a: 3 mm, b: {value: 2 cm, std: 1 mm}}",
      "{value: {a: 1 mm, b: 1 m}, covariance: [[4, 0.001], [0.001, 1e-6]]}",
      "{value: 5 mm, std: 2 mm}",
      "-11.5e-1 deg",
      "{angle: {value: 270 deg, std: 1 deg}, side: right, ratio: 3 %}",
      "{a: $k, b: 0}"};
  const std::array<const PayloadDescriptor*, 3> payloads = {
      &descriptor<test::Scalar>(), &descriptor<test::Pair>(), &descriptor<test::Turn>()};
  const Plan commanded = test::plan_of(
      "modules: {h: {type: head}}\nnetwork: h\n"
      "commands: {q: h.rotate_to, n: h.zoom, i: h.sweeps, b: h.light, t: h.label, c: h.mode}");
  int values = 0;
  for (std::uint64_t seed = first_seed; seed < first_seed + count; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RandomBits random(seed);
    const std::string text = mutated(texts[draw(random, texts.size())], random);
    for (const PayloadDescriptor* payload : payloads) {
      Diagnostics diagnostics;
      SourceOwners owners;
      std::optional<GivenEstimate> given;
      ASSERT_NO_THROW({
        const Node node = parse_document(text, "value", diagnostics);
        given = read_estimate(node, *payload, "name", owners, diagnostics);
        (void)parse_override("a.b=" + text, "--set", diagnostics);
        (void)parse_override(text, "--set", diagnostics);
        for (const PlanCommand& command : commanded.commands)
          (void)parse_command(command.name + "=" + text, commanded, "--command", diagnostics);
        (void)parse_command(text, commanded, "--command", diagnostics);
      }) << text;
      ASSERT_TRUE(given || !diagnostics.empty()) << text;
      if (!given) continue;
      ++values;
      for (const double x : given->estimate.value) ASSERT_TRUE(std::isfinite(x)) << text;
      ASSERT_TRUE(given->estimate.lineage.covariance().allFinite()) << text;
    }
  }
  EXPECT_GT(values, count / 20);
}

}  // namespace
}  // namespace ilss
