#include "framework/graph/given_outputs.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ilss {
namespace {

/// Gives an operating point at every tick.
class GivenOutput final : public Module {
 public:
  /// `described` says what the point leaves open: unknown components, or the error.
  GivenOutput(OperatingPoint point, std::unique_ptr<Module> described)
      : point_(std::move(point)), described_(std::move(described)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override {
    return expect(evaluation, nullptr, output);
  }

  Outcome<> expect(const Evaluation& evaluation, const Output*, Output& output) override {
    if (described_ != nullptr) {
      Outcome<> outcome = described_->expect(evaluation, &point_.value, output);
      if (!outcome || !point_.has_error) return outcome;
      add_given(output.estimate);
      return {};
    }
    const std::string frame = output.estimate.frame;
    output = point_.value;
    output.estimate.frame = frame;
    output.acquired = Acquisition::at(evaluation.time);
    return {};
  }

 private:
  /// What was given stands with its own error; what was not is as the module says.
  void add_given(Estimate& estimate) const {
    const Estimate& given = point_.value.estimate;
    Lineage lineage(given.dimension());
    for (std::size_t k = 0; k < estimate.lineage.size(); ++k)
      for (std::size_t c = 0; c < given.dimension(); ++c)
        if (std::isnan(given.value[c]))
          lineage.add(estimate.lineage.sources()[k], c, estimate.lineage.column(k)[c]);
    for (std::size_t k = 0; k < given.lineage.size(); ++k)
      lineage.add(given.lineage.sources()[k], given.lineage.column(k));
    estimate.lineage = std::move(lineage);
    for (std::size_t c = 0; c < given.dimension(); ++c)
      if (!std::isnan(given.value[c])) estimate.value[c] = given.value[c];
  }

  OperatingPoint point_;
  std::unique_ptr<Module> described_;
};

bool is_complete(const Estimate& estimate) {
  return std::none_of(estimate.value.begin(), estimate.value.end(),
                      [](double value) { return std::isnan(value); });
}

}  // namespace

StandIns given_outputs(std::map<std::size_t, OperatingPoint> points) {
  return [points = std::move(points)](std::size_t index, const PlanNode& node) -> StandIn {
    const auto point = points.find(index);
    if (point == points.end()) return {};
    const bool is_whole = point->second.has_error && is_complete(point->second.value.estimate);
    auto described = is_whole ? nullptr : node.type->create(node.settings);
    return {std::make_unique<GivenOutput>(point->second, std::move(described)), true};
  };
}

ModuleType given_type(std::string name, const PayloadDescriptor& payload) {
  ModuleType type;
  type.name = std::move(name);
  type.kind = ModuleKind::sensor;
  type.parameters = &no_parameters();
  type.interface = [&payload](const Settings&) { return Interface{{}, &payload, {}, {}}; };
  type.create = [](const Settings&) -> std::unique_ptr<Module> {
    throw std::logic_error("its output must be given");
  };
  return type;
}

}  // namespace ilss
