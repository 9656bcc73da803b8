#include "framework/graph/wiring.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <queue>

#include "framework/estimate/dimension.h"

namespace ilss {
namespace {

bool same_inputs(const std::vector<PlanInput>& a, const std::vector<PlanInput>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const PlanInput& x, const PlanInput& y) {
                      return x.node == y.node && x.max_age == y.max_age;
                    });
}

}  // namespace

Instance Wiring::wire(const Expression& network, Scope& scope) {
  connections_.resize(nodes_.size());
  const Flow flow = follow(network, {}, scope);
  check_used(network, scope);
  Instance system{.outputs = {}, .counted = flow.counted};
  for (const PlanInput& output : flow.outputs) system.outputs.push_back(output.node);
  return system;
}

bool Wiring::is_known(const Flow& flow) {
  return flow.counted && std::none_of(flow.outputs.begin(), flow.outputs.end(),
                                      [](const PlanInput& i) { return i.node == unknown_node; });
}

Wiring::Flow Wiring::follow(const Expression& expression, const Flow& feed, Scope& scope) {
  switch (expression.kind) {
    case Expression::Kind::name:
      return follow_name(expression, feed, scope);
    case Expression::Kind::serial: {
      Flow flow = feed;
      for (const Expression& part : expression.parts) flow = follow(part, flow, scope);
      return flow;
    }
    case Expression::Kind::combine: {
      Flow side_by_side;
      for (const Expression& part : expression.parts) {
        const Flow flow = follow(part, feed, scope);
        side_by_side.counted &= flow.counted;
        for (PlanInput output : flow.outputs) {
          if (expression.max_age)
            output.max_age = std::min(output.max_age.value_or(*expression.max_age),  //
                                      *expression.max_age);
          side_by_side.outputs.push_back(output);
        }
      }
      return side_by_side;
    }
    case Expression::Kind::unread:
      for (const Expression& part : expression.parts)
        follow(part, {.outputs = {}, .counted = false}, scope);
      break;
  }
  return {.outputs = {}, .counted = false};
}

Wiring::Flow Wiring::follow_name(const Expression& expression, const Flow& feed, Scope& scope) {
  const auto found = scope.find(expression.name);
  if (found == scope.end()) {
    std::vector<std::string> names;
    for (const auto& [name, instance] : scope) names.push_back(name);
    diagnostics_.add(expression.position, fmt::format("there is no module '{}'{}", expression.name,
                                                      suggestion(expression.name, names)));
    return {.outputs = {{unknown_node}}};
  }
  Instance& instance = found->second;
  instance.used = true;
  Flow flow{.outputs = {}, .counted = instance.counted};
  for (const std::size_t node : instance.outputs) flow.outputs.push_back({node});
  if (feed.outputs.empty() && feed.counted) return flow;
  if (instance.nested && !feed.outputs.empty())
    diagnostics_.add(expression.position,
                     fmt::format("'{}' is a system without inputs and cannot stand after another "
                                 "module",
                                 expression.name));
  else if (!instance.nested && instance.outputs.front() != unknown_node)
    connect(instance.outputs.front(), expression, feed);
  return flow;
}

void Wiring::connect(std::size_t node, const Expression& expression, const Flow& feed) {
  Connection& connection = connections_[node];
  std::vector<PlanInput>& inputs = nodes_[node].inputs;
  if (!connection.made) {
    connection = {true, feed.counted, expression.position};
    inputs = feed.outputs;
    return;
  }
  if (!is_known({inputs, connection.counted}) || !is_known(feed)) return;
  if (!same_inputs(inputs, feed.outputs))
    diagnostics_.add(expression.position,
                     fmt::format("'{}' has its inputs already from line {}; an instance is "
                                 "evaluated once a tick",
                                 expression.name, connection.position.line));
}

std::vector<std::size_t> Wiring::evaluation_order() {
  connections_.resize(nodes_.size());
  // Kahn's algorithm; ready nodes are taken in the order of their declaration.
  std::vector<std::size_t> waiting_for(nodes_.size(), 0);
  std::vector<std::vector<std::size_t>> consumers(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (const PlanInput& input : nodes_[i].inputs) {
      if (input.node == unknown_node) continue;
      ++waiting_for[i];
      consumers[input.node].push_back(i);
    }
  }
  std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> ready;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (waiting_for[i] == 0) ready.push(i);
  std::vector<std::size_t> order;
  while (!ready.empty()) {
    const std::size_t node = ready.top();
    ready.pop();
    order.push_back(node);
    for (const std::size_t consumer : consumers[node])
      if (--waiting_for[consumer] == 0) ready.push(consumer);
  }
  if (order.size() == nodes_.size()) return order;
  report_cycles(waiting_for);
  // What waits for a cycle still has its connections checked.
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (waiting_for[i] != 0) order.push_back(i);
  return order;
}

void Wiring::report_cycles(const std::vector<std::size_t>& waiting_for) {
  // Walking back along nodes that still wait ends in a cycle, or where an earlier walk has been.
  std::vector<std::size_t> visited_by(nodes_.size(), 0);
  for (std::size_t start = 0; start < nodes_.size(); ++start) {
    std::vector<std::size_t> path;
    std::size_t at = start;
    while (waiting_for[at] != 0 && visited_by[at] == 0) {
      visited_by[at] = start + 1;
      path.push_back(at);
      for (const PlanInput& input : nodes_[at].inputs)
        if (input.node != unknown_node && waiting_for[input.node] != 0) {
          at = input.node;
          break;
        }
    }
    if (path.empty() || visited_by[at] != start + 1) continue;
    std::vector<std::string> names = {nodes_[at].name};
    for (std::size_t i = path.size(); i-- > 0;) {
      names.push_back(nodes_[path[i]].name);
      if (path[i] == at) break;
    }
    diagnostics_.add(connections_[at].position,
                     fmt::format("a cycle: {}", fmt::join(names, " -> ")));
  }
}

void Wiring::check_connections(const std::vector<std::size_t>& order) {
  for (const std::size_t index : order) {
    PlanNode& node = nodes_[index];
    const std::vector<InputDeclaration>& declared = node.interface.inputs;
    const Connection& connection = connections_[index];
    const bool repeated = !declared.empty() && declared.back().repeated;
    const std::size_t given = node.inputs.size();
    if (connection.counted && given != 0 &&
        (repeated ? given < declared.size() : given != declared.size())) {
      std::vector<std::string> names;
      for (const PlanInput& input : node.inputs)
        names.push_back(input.node == unknown_node ? "?" : nodes_[input.node].name);
      diagnostics_.add(connection.position,
                       fmt::format("'{}' ({}) has {}{} input{}, but is fed by {}: {}", node.name,
                                   node.type->name, repeated ? "at least " : "", declared.size(),
                                   declared.size() == 1 ? "" : "s", given, fmt::join(names, ", ")));
    }
    if (node.type != nullptr && node.type->resolve && connection.counted) resolve(index);
    for (std::size_t i = 0; connection.counted && i < given && !declared.empty(); ++i)
      if ((repeated || i < declared.size()) && node.inputs[i].node != unknown_node)
        check_input(index, i);
    node.frame = node.interface.frame;
    const auto from = node.interface.frame_of_input;
    if (node.frame.empty() && from && connection.counted && *from < given &&
        node.inputs[*from].node != unknown_node)
      node.frame = nodes_[node.inputs[*from].node].frame;
  }
  check_payload_names(order);
}

void Wiring::check_payload_names(const std::vector<std::size_t>& order) {
  std::map<std::string_view, std::size_t> producer_of;
  for (const std::size_t index : order) {
    const PlanNode& node = nodes_[index];
    if (node.interface.output == nullptr) continue;
    const auto [first, fresh] = producer_of.emplace(node.interface.output->name, index);
    const PlanNode& other = nodes_[first->second];
    if (fresh || same_payload(*other.interface.output, *node.interface.output)) continue;
    diagnostics_.add(node.position,
                     fmt::format("'{}' gives a payload '{}' of other components than '{}' does; "
                                 "payloads are told apart by name",
                                 node.name, node.interface.output->name, other.name));
  }
}

void Wiring::resolve(std::size_t index) {
  PlanNode& node = nodes_[index];
  if (!node.readable) return;  // what is wrong has been said
  Connections connections{{}, connections_[index].position, &diagnostics_};
  if (connections.position.line == 0) connections.position = node.position;
  for (const PlanInput& input : node.inputs) {
    if (input.node == unknown_node) return;
    // One that is not known had its own complaint.
    const PayloadDescriptor* payload = nodes_[input.node].interface.output;
    if (payload == &any_payload()) return;
    connections.inputs.push_back(payload);
  }
  const std::vector<InputDeclaration>& declared = node.interface.inputs;
  const bool repeated = !declared.empty() && declared.back().repeated;
  if (repeated ? node.inputs.size() < declared.size() : node.inputs.size() != declared.size())
    return;
  try {
    node.type->resolve(connections, node.settings, node.interface);
  } catch (const std::exception& error) {
    diagnostics_.add(node.position, fmt::format("module type '{}' is defective: {}",
                                                node.type->name, error.what()));
  }
  adopt_registered_payload(node);
}

/// A payload that a graph defines under the name of a registered one is that one, labels and all,
/// if its components are the same; other modules tell payloads apart by name.
void Wiring::adopt_registered_payload(PlanNode& node) {
  const PayloadDescriptor& made = *node.interface.output;
  const PayloadDescriptor* known = registry_.find_payload(made.name);
  if (known == nullptr || same_payload(*known, made)) return;
  const bool same_components =
      std::equal(made.components.begin(), made.components.end(), known->components.begin(),
                 known->components.end(), [](const Component& a, const Component& b) {
                   return a.name == b.name && Dimension::of(a.unit) == Dimension::of(b.unit);
                 });
  if (same_components && !known->samples && known->element.empty()) {
    node.interface.output = known;
    return;
  }
  std::vector<std::string> components;
  for (const Component& component : known->components)
    components.push_back(fmt::format("{} ({})", component.name, component.unit));
  diagnostics_.add(node.position, fmt::format("'{}' gives a payload '{}' of other components than "
                                              "that has: {}; name it otherwise",
                                              node.name, made.name, fmt::join(components, ", ")));
}

void Wiring::check_input(std::size_t index, std::size_t i) {
  const PlanNode& node = nodes_[index];
  const Position& position = connections_[index].position;
  const std::vector<InputDeclaration>& declared = node.interface.inputs;
  const InputDeclaration& input = declared[std::min(i, declared.size() - 1)];
  const PlanNode& producer = nodes_[node.inputs[i].node];
  const bool any = input.payload == &any_payload() || producer.interface.output == &any_payload();
  if (!any && producer.interface.output->name != input.payload->name)
    return diagnostics_.add(position, fmt::format("'{}' gives {}, but input '{}' of '{}' takes {}",
                                                  producer.name, producer.interface.output->name,
                                                  input.name, node.name, input.payload->name));
  if (producer.frame.empty()) return;  // not known, or its numbers have no place in space
  if (!input.frame.empty() && producer.frame != input.frame)
    return diagnostics_.add(
        position, fmt::format("'{}' gives {} in frame '{}', but input '{}' of '{}' is in frame "
                              "'{}'; put a transform between them",
                              producer.name, input.payload->name, producer.frame, input.name,
                              node.name, input.frame));
  if (!input.frame.empty()) return;
  for (std::size_t j = 0; j < i; ++j) {
    const InputDeclaration& earlier = declared[std::min(j, declared.size() - 1)];
    if (node.inputs[j].node == unknown_node || !earlier.frame.empty()) continue;
    const PlanNode& other = nodes_[node.inputs[j].node];
    if (other.frame.empty() || other.frame == producer.frame) continue;
    return diagnostics_.add(
        position, fmt::format("'{}' is in frame '{}', but '{}' in frame '{}'; inputs of '{}' must "
                              "share a frame",
                              other.name, other.frame, producer.name, producer.frame, node.name));
  }
}

void Wiring::check_used(const Expression& network, const Scope& scope) {
  for (const auto& [name, instance] : scope) {
    if (!instance.used && !network.hides_names)
      diagnostics_.add(instance.position,
                       fmt::format("module '{}' is not used in the network", name));
    if (!instance.used || instance.nested || instance.outputs.front() == unknown_node) continue;
    const std::size_t index = instance.outputs.front();
    const PlanNode& node = nodes_[index];
    if (connections_[index].made || node.interface.inputs.empty()) continue;
    std::vector<std::string> names;
    for (const InputDeclaration& input : node.interface.inputs)
      names.push_back(fmt::format("{} ({})", input.name, input.payload->name));
    diagnostics_.add(node.position, fmt::format("'{}' has unconnected inputs: {}", node.name,
                                                fmt::join(names, ", ")));
  }
}

}  // namespace ilss
