// A plug-in for tests of the command: a turntable that follows commands, and a formula that steers
// it.
#include <cmath>

#include "framework/module/registry.h"

namespace ilss {
namespace {

template <typename T>
struct TableAngle {
  T angle;
  static constexpr std::string_view name = "table_angle";
  static constexpr auto fields = Fields{{"angle", "rad", "of the table"}};
};

/// Stands where it was told to; turns by at most a right angle from its zero.
class Turntable final : public Module {
 public:
  static constexpr std::string_view name = "turntable";
  static constexpr std::string_view description = "a table that turns where it is told";
  static constexpr ModuleKind kind = ModuleKind::sensor;
  static Interface interface() { return {{}, &descriptor<TableAngle>(), {}, {}}; }
  static std::vector<CommandDeclaration> commands() {
    return {quantity_command("rotate_to", "rad", "turns the table to this angle"),
            choice_command("mode", {"fast", "smooth"}, "how it moves"),
            boolean_command("jam", "makes it throw")};
  }
  Outcome<> evaluate(const Evaluation&, Output& output) override {
    assign<TableAngle>(output.estimate, {angle_});
    return {};
  }
  Outcome<> command(const Command& command) override {
    if (command.name == "jam") throw std::runtime_error("jammed");
    if (command.name == "mode") return {};
    const double angle = std::get<double>(command.value);
    if (std::abs(angle) > std::acos(0.0))
      return Fault{FaultKind::refused, "the table turns by at most 90 deg"};
    angle_ = angle;
    return {};
  }

 private:
  double angle_ = 0;
};

/// The angle, and a step more.
struct NextAngle {
  static constexpr std::string_view name = "next_angle";
  static constexpr std::string_view description = "an angle and a step more";
  static constexpr std::array<std::string_view, 1> inputs = {"angle"};
  template <typename T>
  struct Parameters {
    T step;
    static constexpr std::string_view name = "next_angle_parameters";
    static constexpr auto fields = Fields{{"step", "rad", "from tick to tick"}};
  };
  template <typename T>
  Outcome<TableAngle<T>> operator()(const Parameters<T>& p, const TableAngle<T>& at) const {
    return TableAngle<T>{at.angle + p.step};
  }
};

}  // namespace
}  // namespace ilss

extern "C" void ilss_register(ilss::Registry& registry) {
  registry.add<ilss::Turntable>();
  registry.add<ilss::NextAngle>();
}
