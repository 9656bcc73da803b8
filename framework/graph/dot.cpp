#include "framework/graph/dot.h"

#include <fmt/format.h>

#include <map>

namespace ilss {
namespace {

/// Text in DOT's double quotes. Line feeds are written as `\n`.
std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    if (c == '\n')
      result += "\\n";
    else
      result += c;
  }
  return result + "\"";
}

/// Text inside DOT's HTML-like labels.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

/// Nodes of one system, and the systems in it by name.
struct Cluster {
  std::vector<std::size_t> nodes;
  std::map<std::string, Cluster> systems;
};

Cluster clusters_of(const Plan& plan) {
  Cluster top;
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    Cluster* at = &top;
    std::string_view rest = plan.nodes[i].name;
    for (std::size_t dot = rest.find('.'); dot != std::string_view::npos; dot = rest.find('.')) {
      at = &at->systems[std::string(rest.substr(0, dot))];
      rest.remove_prefix(dot + 1);
    }
    at->nodes.push_back(i);
  }
  return top;
}

/// Shape and colours that tell the kinds apart, in print as well.
std::string_view style_of(ModuleKind kind) {
  switch (kind) {
    case ModuleKind::sensor:
      return R"(shape=cds, fillcolor="#d7ebf7", color="#2b6c99")";
    case ModuleKind::function:
      return R"(shape=box, fillcolor="#fdf3d8", color="#a5781e")";
    case ModuleKind::estimator:
      return R"(shape=box, peripheries=2, fillcolor="#e2f2df", color="#3f7f3a")";
  }
  return "";
}

std::string milliseconds(const ModuleTime& time) {
  const std::string typical = fmt::format("{:.3g}", time.typical * 1e3);
  const std::string worst = fmt::format("{:.3g}", time.worst * 1e3);
  return typical == worst ? typical + " ms" : fmt::format("{}\u2013{} ms", typical, worst);
}

std::string node_text(const Plan& plan, std::size_t i) {
  const PlanNode& node = plan.nodes[i];
  const std::size_t dot = node.name.rfind('.');
  const std::string name = dot == std::string::npos ? node.name : node.name.substr(dot + 1);
  std::string lines = fmt::format("<b>{}</b>", escaped(name));
  if (name != node.type->name)
    lines += fmt::format("<br/><font point-size=\"10\">{}</font>", escaped(node.type->name));
  if (node.time)
    lines += fmt::format("<br/><font point-size=\"9\">{}</font>", milliseconds(*node.time));
  return fmt::format("n{} [label=<{}>, tooltip={}, {}];", i, lines,
                     in_quotes(node.type->description), style_of(node.type->kind));
}

void write_cluster(const Plan& plan, const Cluster& cluster, const std::string& path, int depth,
                   std::string& out) {
  const std::string indent(static_cast<std::size_t>(2 * depth), ' ');
  for (const std::size_t node : cluster.nodes)
    out += fmt::format("{}{}\n", indent, node_text(plan, node));
  for (const auto& [name, inner] : cluster.systems) {
    const std::string inner_path = fmt::format("{}.{}", path, name);
    out += fmt::format("{}subgraph {} {{\n{}  label={};\n", indent,
                       in_quotes("cluster" + inner_path), indent, in_quotes(name));
    write_cluster(plan, inner, inner_path, depth + 1, out);
    out += indent + "}\n";
  }
}

/// What flows out of a node: payload, and the frame it is in.
std::string flow_label(const PlanNode& node) {
  std::string label = escaped(node.interface.output->name);
  if (!node.frame.empty())
    label += fmt::format("<br/><font color=\"#777777\">in {}</font>", escaped(node.frame));
  return label;
}

/// A driven command acts on later ticks: it does not order the nodes.
std::string drive_text(const Plan& plan, const PlanCommand& command) {
  const PlanNode& from = plan.nodes[command.driver->node];
  const Component& component = from.interface.output->components[command.driver->component];
  return fmt::format(
      "  n{} -> n{} [label=<{}<br/><font color=\"#777777\">from {}</font>>, style=dashed, "
      "constraint=false];\n",
      command.driver->node, command.node, escaped(command.name), escaped(component.name));
}

}  // namespace

std::string to_dot(const Plan& plan) {
  std::string out = fmt::format(
      "digraph {} {{\n"
      "  rankdir=LR; nodesep=0.35; ranksep=0.6;\n"
      "  fontname=\"Helvetica\"; fontsize=12; labelloc=t; style=\"rounded\"; color=\"#999999\";\n"
      "  node [fontname=\"Helvetica\", fontsize=12, style=\"filled\", margin=\"0.18,0.1\"];\n"
      "  edge [fontname=\"Helvetica\", fontsize=10, color=\"#555555\", arrowsize=0.8];\n",
      in_quotes(plan.name));
  if (!plan.name.empty()) out += fmt::format("  label={};\n", in_quotes(plan.name));
  write_cluster(plan, clusters_of(plan), "", 1, out);
  for (std::size_t i = 0; i < plan.nodes.size(); ++i)
    for (std::size_t k = 0; k < plan.nodes[i].inputs.size(); ++k) {
      const PlanInput& input = plan.nodes[i].inputs[k];
      std::string label = flow_label(plan.nodes[input.node]);
      if (input.max_age) label += fmt::format("<br/>at most {:.4g} s old", seconds(*input.max_age));
      out += fmt::format("  n{} -> n{} [label=<{}>];\n", input.node, i, label);
    }
  for (const PlanCommand& command : plan.commands)
    if (command.driver) out += drive_text(plan, command);
  for (std::size_t o = 0; o < plan.outputs.size(); ++o) {
    const std::string name = plan.outputs.size() == 1 ? "output" : fmt::format("output {}", o + 1);
    out += fmt::format("  output{} [label={}, shape=plaintext, style=\"\"];\n", o, in_quotes(name));
    out += fmt::format("  n{} -> output{} [label=<{}>, penwidth=2];\n", plan.outputs[o], o,
                       flow_label(plan.nodes[plan.outputs[o]]));
  }
  return out + "}\n";
}

}  // namespace ilss
