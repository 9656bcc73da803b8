// A choice among cameras passes an image on as it is.
#include <gtest/gtest.h>

#include "framework/graph/system.h"
#include "sensors/camera/image.h"
#include "tests/allocation_count.h"
#include "tests/framework/graph/read_graph.h"

namespace ilss {
namespace {

/// A camera of 640 x 480 pixels, all as bright as the tick's number.
class Still final : public Module {
 public:
  static constexpr std::string_view name = "still";
  static constexpr std::string_view description = "An even image";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    void declare(OptionVisitor&) {}
  };
  static Interface interface() { return {{}, &descriptor<Image>(), {}, {}}; }
  explicit Still(const Options&) {}
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    const auto levels = make_levels(output.samples, 480, 640);
    std::fill(levels.begin(), levels.end(), static_cast<std::uint8_t>(evaluation.tick));
    return {};
  }
};

/// Passes on one camera's image after the other's.
class Alternate final : public Selector {
 public:
  static constexpr std::string_view name = "alternate";
  static constexpr std::string_view description = "One image after the other";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  struct Options {
    void declare(OptionVisitor&) {}
  };
  static Interface interface() {
    return {{{"images", &descriptor<Image>(), {}, true}}, &descriptor<Image>(), {}, 0};
  }
  explicit Alternate(const Options&) {}
  Outcome<std::size_t> select(const Evaluation& evaluation, Branches& branches) override {
    const std::size_t wanted = static_cast<std::size_t>(evaluation.tick) % branches.size();
    branches.evaluate(wanted);
    return wanted;
  }
};

/// The level of an image's first pixel.
class FirstLevel final : public Module {
 public:
  static constexpr std::string_view name = "first_level";
  static constexpr std::string_view description = "The level of the first pixel";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  struct Options {
    void declare(OptionVisitor&) {}
  };
  static Interface interface() {
    return {{{"image", &descriptor<Image>()}}, &descriptor<test::Scalar>(), {}, {}};
  }
  explicit FirstLevel(const Options&) {}
  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    output.estimate.value.at(0) = levels_of(*evaluation.inputs[0])[0];
    return {};
  }
};

TEST(SelectedImage, IsNeitherCopiedNorAllocatedFor) {
  SKIP_UNLESS_ALLOCATIONS_ARE_COUNTED();
  Registry registry;
  registry.add<Still>();
  registry.add<Alternate>();
  registry.add<FirstLevel>();
  Diagnostics diagnostics;
  const Node graph = parse_document(R"(
modules:
  left: {type: still}
  right: {type: still}
  use: {type: alternate}
  level: {type: first_level}
network: {serial: [combine: [left, right], use, level]}
)",
                                    "graph.yaml", diagnostics);
  const auto plan = build_plan(graph, ".", registry, {}, diagnostics);
  ASSERT_EQ(test::messages(diagnostics), "");
  System system(*plan, 1);
  const auto output = [&](std::string_view name) -> const Output& {
    return system.node(plan->find(name).value()).output();
  };
  for (int tick = 0; tick < 4; ++tick) system.evaluate(time_at(tick));
  const std::size_t before = allocation_count;
  for (int tick = 4; tick < 100; ++tick) {
    system.evaluate(time_at(tick));
    EXPECT_EQ(&output("use"), &output(tick % 2 == 0 ? "left" : "right"));
    EXPECT_EQ(output("level").estimate.value[0], tick);
  }
  EXPECT_EQ(allocation_count - before, 0U);
}

}  // namespace
}  // namespace ilss
