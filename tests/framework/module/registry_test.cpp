// The registry: names are taken once, payloads mean one thing.
#include "framework/module/registry.h"

#include <gtest/gtest.h>

#include <functional>

#include "framework/module/sample_rows.h"

namespace ilss {
namespace {

template <typename T>
struct Metres {
  T x;
  static constexpr std::string_view name = "registry_payload";
  static constexpr auto fields = Fields{{"x", "m"}};
};
template <typename T>
struct Radians {
  T x;
  static constexpr std::string_view name = "registry_payload";
  static constexpr auto fields = Fields{{"x", "rad"}};
};
template <typename T>
struct CircularMetres {
  T x;
  static constexpr std::string_view name = "registry_payload";
  static constexpr auto fields = Fields{{"x", "m", "", required, Geometry::circular}};
};

struct Beam {
  double range = 0;
  static constexpr auto columns = Columns{column(&Beam::range, "range", "m")};
};
struct FineBeam {
  float range = 0;
  static constexpr auto columns = Columns{column(&FineBeam::range, "range", "m")};
};
template <typename T>
struct CoarseScan {
  T noise;
  static constexpr std::string_view name = "registry_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<Beam>("beam"); }
};
template <typename T>
struct FineScan {
  T noise;
  static constexpr std::string_view name = "registry_scan";
  static constexpr auto fields = Fields{{"noise", "m"}};
  static SamplesDescriptor samples() { return samples_of_rows<FineBeam>("beam"); }
};

template <template <typename> class Payload>
struct Identity {
  static constexpr std::string_view name = "identity", description = "its input";
  static constexpr std::array<std::string_view, 1> inputs = {"in"};
  static constexpr std::array faults = {FaultKind::degenerate};
  template <typename T>
  Outcome<Payload<T>> operator()(const Payload<T>& in) const {
    return in;
  }
};
struct OtherRadians : Identity<Radians> {
  static constexpr std::string_view name = "other";
};
struct OtherCircular : Identity<CircularMetres> {
  static constexpr std::string_view name = "other";
};
struct OfScans : Identity<CoarseScan> {
  static constexpr std::string_view name = "of_scans";
};
struct OfFineScans : Identity<FineScan> {
  static constexpr std::string_view name = "of_fine_scans";
};
struct OtherMetres : Identity<Metres> {
  static constexpr std::string_view name = "other";
};

struct Constant {
  static constexpr std::string_view name = "constant", description = "a parameter";
  static constexpr std::array<std::string_view, 0> inputs = {};
  template <typename T>
  struct Parameters {
    T x;
    static constexpr std::string_view name = "constant_parameters";
    static constexpr auto fields = Fields{{"x", "m"}};
  };
  template <typename T>
  Outcome<Metres<T>> operator()(const Parameters<T>& p) const {
    return Metres<T>{p.x};
  }
};

class Sensor : public Module {
 public:
  static constexpr std::string_view name = "sensor", description = "a sensor";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  struct Options {
    int rows = 4;
    void declare(OptionVisitor& visit) { visit("rows", rows, "how many"); }
  };
  explicit Sensor(const Options& options) : rows_(options.rows) {}
  static Interface interface() { return {{}, &descriptor<Metres>(), "robot", {}}; }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    output.estimate.value = {static_cast<double>(rows_)};
    return {};
  }

 private:
  int rows_;
};

std::string refusal(Registry& registry, const std::function<void(Registry&)>& add) {
  try {
    add(registry);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Registry, FindsWhatWasAdded) {
  Registry registry;
  registry.add<Identity<Metres>>();
  registry.add<Sensor>();
  EXPECT_EQ(registry.names(), (std::vector<std::string>{"identity", "sensor"}));
  EXPECT_EQ(registry.find("identity")->faults, std::vector{FaultKind::degenerate});
  EXPECT_EQ(registry.find("sensor")->kind, ModuleKind::sensor);
  EXPECT_EQ(registry.find("sensor")->options.front().default_text, "4");
  EXPECT_EQ(registry.find("nothing"), nullptr);
  EXPECT_EQ(registry.find_payload("registry_payload"), &descriptor<Metres>());
  EXPECT_EQ(registry.find_payload("nothing"), nullptr);
}

TEST(Registry, RefusesAPayloadWithOtherColumns) {
  Registry registry;
  registry.add<OfScans>();
  EXPECT_EQ(refusal(registry, [](Registry& r) { r.add<OfFineScans>(); }),
            "payload 'registry_scan' is declared twice, with different components, labels, samples "
            "or elements");
}

TEST(Registry, RefusesANameThatIsTaken) {
  Registry registry;
  registry.add<Identity<Metres>>();
  EXPECT_EQ(refusal(registry, [](Registry& r) { r.add<Identity<Metres>>(); }),
            "module type 'identity' is registered twice");
}

TEST(Registry, RefusesAPayloadOfOtherComponentsUnderAKnownName) {
  Registry registry;
  registry.add<Identity<Metres>>();
  const std::string message =
      "payload 'registry_payload' is declared twice, with different components, labels, samples "
      "or elements";
  EXPECT_EQ(refusal(registry, [](Registry& r) { r.add<OtherRadians>(); }), message);
  EXPECT_EQ(refusal(registry, [](Registry& r) { r.add<OtherCircular>(); }), message);
  EXPECT_EQ(registry.find("other"), nullptr);
  EXPECT_EQ(refusal(registry, [](Registry& r) { r.add<OtherMetres>(); }), "accepted");
}

/// The type of a sensor that declares these commands.
ModuleType commanded(std::vector<CommandDeclaration> commands) {
  ModuleType type = module_type<Sensor>();
  type.commands = std::move(commands);
  return type;
}

TEST(Registry, RefusesCommandsThatNoGraphCouldGive) {
  const auto answer = [](const std::vector<CommandDeclaration>& commands) {
    Registry registry;
    return refusal(registry, [&](Registry& r) { r.add(commanded(commands)); });
  };
  EXPECT_EQ(answer({quantity_command("zoom", "rad", ""), text_command("label", "")}), "accepted");
  EXPECT_EQ(answer({number_command("a.b", "")}),
            "module type 'sensor': 'a.b' cannot name a command");
  EXPECT_EQ(answer({number_command("zoom", ""), text_command("zoom", "")}),
            "module type 'sensor': command 'zoom' is declared twice");
  EXPECT_EQ(answer({quantity_command("zoom", "", "")}),
            "module type 'sensor': command 'zoom' takes a quantity without a unit");
  CommandDeclaration list = number_command("zoom", "");
  list.value.kind = ParameterDeclaration::Kind::list;
  EXPECT_EQ(answer({list}), "module type 'sensor': command 'zoom' cannot take a list");
}

TEST(Registry, MakesModulesFromTheirOptions) {
  Registry registry;
  registry.add<Sensor>();
  const ModuleType& type = *registry.find("sensor");
  Diagnostics diagnostics;
  const Node map = parse_document("rows: 9", "f", diagnostics);
  const Settings settings{type.read_options(&map, ".", diagnostics, {}), "."};
  const auto module = type.create(settings);
  Output output;
  const Estimate none;
  ASSERT_TRUE(module->evaluate({.parameters = none, .inputs = {}}, output));
  EXPECT_EQ(output.estimate.value, std::vector{9.0});
}

TEST(Registry, TakesFunctionsWithoutInputs) {
  Registry registry;
  registry.add<Constant>();
  const Interface interface = registry.find("constant")->interface(Settings{});
  EXPECT_TRUE(interface.inputs.empty());
  EXPECT_FALSE(interface.frame_of_input.has_value());
}

TEST(LoadPlugin, SaysWhatIsWrong) {
  Registry registry;
  try {
    load_plugin("/nowhere/plugin.so", registry);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).substr(0, 42),
              "cannot load plug-in: /nowhere/plugin.so: c");
  }
}

TEST(Module, WithoutOwnHandlersRefusesCommandsAndKnowsNoExpectedError) {
  FunctionModule<Identity<Metres>> module{Identity<Metres>{}};
  const Outcome<> refused = module.command({"zoom", {}});
  ASSERT_TRUE(refused.is_fault());
  EXPECT_EQ(refused.fault().kind, FaultKind::refused);
  EXPECT_EQ(refused.fault().message, "the module knows no command 'zoom'");
  Output input;
  input.estimate = Estimate(descriptor<Metres>());
  input.estimate.lineage.add({0, 0, 0}, 0, 2.0);
  const Output* inputs[] = {&input};
  const Estimate none;
  const Evaluation evaluation{.parameters = none, .inputs = inputs};
  Output output;
  EXPECT_EQ(module.expect(evaluation, &input, output).fault().kind, FaultKind::no_error_known);
  ASSERT_TRUE(module.expect(evaluation, nullptr, output));
  EXPECT_EQ(output.estimate.lineage.variance(0), 4.0);
}

}  // namespace
}  // namespace ilss
