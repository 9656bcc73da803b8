#include "sensors/formula/formula_interface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

constexpr std::size_t most_outputs = 64;

void check_name(const Node& name, std::string_view what, const std::vector<PlacedName>& taken,
                Diagnostics& diagnostics) {
  if (!is_formula_name(name.text))
    diagnostics.add(name.position,
                    fmt::format("'{}' cannot name {}: a name is of letters, digits and _, and does "
                                "not begin with a digit",
                                name.text, what));
  else if (is_formula_word(name.text))
    diagnostics.add(name.position, fmt::format("'{}' cannot name {}: it means something in "
                                               "formulas already",
                                               name.text, what));
  else if (std::any_of(taken.begin(), taken.end(),
                       [&](const PlacedName& other) { return other.text == name.text; }))
    diagnostics.add(name.position, fmt::format("'{}' names two things", name.text));
}

std::string read_text(const Node* module, std::string_view key, Diagnostics& diagnostics) {
  const Node* node = module != nullptr ? module->find(key) : nullptr;
  if (node == nullptr || node->is_null()) return {};
  if (!node->is_scalar())
    diagnostics.add(node->position, "expected a text, got " + node->description());
  return node->text;
}

}  // namespace

std::vector<ParameterDeclaration> interface_declarations() {
  using Kind = ParameterDeclaration::Kind;
  ParameterDeclaration inputs;
  inputs.name = "inputs";
  inputs.kind = Kind::list;
  inputs.documentation = "what to call the modules that feed this one, in order";
  inputs.children.emplace_back();
  ParameterDeclaration payload;
  payload.name = "payload";
  payload.documentation = "what to call the output's payload; by default its components' names";
  ParameterDeclaration frame;
  frame.name = "frame";
  frame.documentation = "the output's frame; by default the first input's";
  return {std::move(inputs), std::move(payload), std::move(frame)};
}

FormulaInterface read_interface(const Node* module, Diagnostics& diagnostics, Position fallback) {
  FormulaInterface interface;
  interface.position = fallback;
  interface.payload = read_text(module, "payload", diagnostics);
  interface.frame = read_text(module, "frame", diagnostics);
  std::vector<PlacedName> taken;
  const auto take = [&](const Node& name, std::string_view what, std::vector<PlacedName>& names) {
    check_name(name, what, taken, diagnostics);
    names.push_back({name.text, name.position});
    taken.push_back(names.back());
  };
  const Node* inputs = module != nullptr ? module->find("inputs") : nullptr;
  if (inputs != nullptr && !inputs->is_list() && !inputs->is_null())
    diagnostics.add(inputs->position, "expected a list of names, got " + inputs->description());
  if (inputs != nullptr && inputs->is_list())
    for (const Node& name : inputs->values) take(name, "an input", interface.inputs);
  const Node* quantities = module != nullptr ? module->find("quantities") : nullptr;
  if (quantities != nullptr && quantities->is_map())
    for (const Node& name : quantities->keys) take(name, "a quantity", interface.quantities);
  return interface;
}

void add_output(FormulaInterface& interface, const Node& name, const Node* unit, bool circular,
                Diagnostics& diagnostics) {
  OutputComponent component{{name.text, name.position}, std::nullopt, circular};
  if (!is_formula_name(name.text))
    diagnostics.add(name.position,
                    fmt::format("'{}' cannot name a component: a name is of letters, digits and _, "
                                "and does not begin with a digit",
                                name.text));
  if (unit == nullptr || unit->is_null())
    diagnostics.add(name.position,
                    fmt::format("component '{}' needs a unit ('1' for a pure number)", name.text));
  else if (unit->is_scalar())
    component.dimension = Dimension::of(unit->text);
  if (unit != nullptr && !unit->is_null() && !component.dimension)
    diagnostics.add(unit->position,
                    fmt::format("expected the unit of '{}' ('1' for a pure number), got {}",
                                name.text, unit->description()));
  if (circular && component.dimension && *component.dimension != Dimension::angle())
    diagnostics.add(name.position, fmt::format("'{}' is no angle and so cannot be circular: it is "
                                               "{}",
                                               name.text, component.dimension->name()));
  if (interface.outputs.size() == most_outputs)
    diagnostics.add(name.position,
                    fmt::format("an output has at most {} components", most_outputs));
  interface.outputs.push_back(std::move(component));
}

Interface open_interface(const FormulaInterface* interface) {
  Interface result;
  result.output = &any_payload();
  result.frame_of_input = 0;
  if (interface == nullptr) {
    result.inputs.push_back({"inputs", &any_payload(), {}, true});
    return result;
  }
  for (const PlacedName& input : interface->inputs)
    result.inputs.push_back({input.text, &any_payload(), {}, false});
  if (interface->inputs.empty()) result.frame_of_input.reset();
  result.frame = interface->frame;
  return result;
}

const PayloadDescriptor* output_payload(const FormulaInterface& interface) {
  PayloadDescriptor payload{interface.payload, "Defined by a graph.", {}};
  for (const OutputComponent& output : interface.outputs) {
    if (!output.dimension) return nullptr;
    if (interface.payload.empty())
      payload.name += (payload.name.empty() ? "" : "_") + output.name.text;
    payload.components.push_back({output.name.text, output.dimension->unit(), "", std::nullopt,
                                  output.circular ? Geometry::circular : Geometry::plain});
  }
  return payload.components.empty() ? nullptr : &intern_payload(std::move(payload));
}

FormulaArguments make_arguments(const FormulaInterface& interface, const Connections& connections,
                                const Settings& settings) {
  FormulaArguments arguments;
  const auto add = [&](const std::string& name, const std::string& unit) {
    // A name such as "mount.x" has its dots; what no formula could name takes part unnamed.
    arguments.names.emplace(name, static_cast<Tape::Index>(arguments.list.size()));
    arguments.list.push_back({name, unit});
  };
  for (std::size_t i = 0; i < connections.inputs.size(); ++i) {
    arguments.first.push_back(arguments.list.size());
    const std::string& input = interface.inputs[i].text;
    const PayloadDescriptor& payload = *connections.inputs[i];
    if (payload.dimension() == 1)
      arguments.names.emplace(input, static_cast<Tape::Index>(arguments.list.size()));
    for (const Component& component : payload.components)
      add(input + "." + component.name, component.unit);
  }
  arguments.first.push_back(arguments.list.size());
  if (settings.quantities != nullptr)
    for (const Component& quantity : settings.quantities->components)
      add(quantity.name.substr(quantity.name.find('.') + 1), quantity.unit);
  arguments.first.push_back(arguments.list.size());
  return arguments;
}

void report_unused(const FormulaInterface& interface, const FormulaArguments& arguments,
                   const std::function<bool(std::size_t)>& used, Diagnostics& diagnostics) {
  const auto report = [&](const PlacedName& name, std::size_t first, std::size_t end) {
    if (!is_formula_name(name.text) || is_formula_word(name.text)) return;  // which was said
    for (std::size_t a = first; a < end; ++a)
      if (used(a)) return;
    diagnostics.add(name.position, fmt::format("'{}' is not used", name.text));
  };
  for (std::size_t i = 0; i < interface.inputs.size(); ++i)
    report(interface.inputs[i], arguments.first[i], arguments.first[i + 1]);
  const std::size_t first = arguments.first[interface.inputs.size()];
  for (std::size_t q = 0; q < interface.quantities.size() && first + q < arguments.list.size(); ++q)
    report(interface.quantities[q], first + q, first + q + 1);
}

ArgumentReader::ArgumentReader(const FormulaArguments& arguments)
    : first_(arguments.first),
      values_(arguments.list.size()),
      terms_(arguments.first.size() - 1),
      in_tangent_(terms_.size()) {}

const Estimate& ArgumentReader::group(const Evaluation& evaluation, std::size_t i) const {
  return i + 1 < terms_.size() ? evaluation.input(i) : evaluation.parameters;
}

std::span<const double> ArgumentReader::values(const Evaluation& evaluation) {
  for (std::size_t i = 0; i < terms_.size(); ++i)
    std::copy_n(group(evaluation, i).value.begin(), first_[i + 1] - first_[i],
                values_.begin() + static_cast<std::ptrdiff_t>(first_[i]));
  return values_;
}

bool ArgumentReader::any_error(const Evaluation& evaluation) {
  return !evaluation.parameters.lineage.empty() ||
         std::any_of(evaluation.inputs.begin(), evaluation.inputs.end(),
                     [](const Output* input) { return !input->estimate.lineage.empty(); });
}

bool ArgumentReader::has_error(const Evaluation& evaluation, std::size_t argument) const {
  std::size_t i = 0;
  while (argument >= first_[i + 1]) ++i;
  const Estimate& estimate = group(evaluation, i);
  // An error of a rotation moves all of its components.
  return is_flat(*estimate.type) ? estimate.lineage.variance(argument - first_[i]) > 0
                                 : !estimate.lineage.empty();
}

void ArgumentReader::propagate(const Evaluation& evaluation, std::span<const double> jacobian,
                               std::size_t rows, Lineage& lineage) {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    const Estimate& estimate = group(evaluation, i);
    terms_[i] = {jacobian.data() + rows * first_[i], &estimate.lineage};
    if (is_flat(*estimate.type)) continue;
    const Eigen::Map<const Eigen::MatrixXd> by_components(
        terms_[i].jacobian, static_cast<Eigen::Index>(rows),
        static_cast<Eigen::Index>(estimate.dimension()));
    in_tangent_[i] = by_components * difference_by_first(*estimate.type, estimate.value);
    terms_[i].jacobian = in_tangent_[i].data();
  }
  if (evaluation.correlation_unknown)
    compose_bounded(terms_, rows, evaluation.fresh(0), lineage);
  else
    compose(terms_, rows, lineage);
}

void settle_result(Estimate& estimate) {
  if (!is_flat(*estimate.type)) {
    const Eigen::MatrixXd to_errors = retract_by_error(*estimate.type, estimate.value);
    const Lineage by_components = estimate.lineage;
    const LineageTerm term{to_errors.data(), &by_components};
    compose({&term, 1}, estimate.dimension(), estimate.lineage);
  }
  normalize(*estimate.type, estimate.value);
}

Outcome<> check_finite(const Estimate& estimate) {
  double squares = 0;
  for (std::size_t k = 0; k < estimate.lineage.size(); ++k)
    for (const double sensitivity : estimate.lineage.column(k))
      squares += sensitivity * sensitivity;
  if (!std::isfinite(squares))
    return Fault{FaultKind::not_finite, "the result's error is too large for a number"};
  for (const double value : estimate.value)
    if (!std::isfinite(value))
      return Fault{FaultKind::not_finite, "the result is too large for a number"};
  return {};
}

}  // namespace ilss
