#include "framework/module/document.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

namespace ilss {
namespace {

constexpr std::size_t most_nodes = 1'000'000;
constexpr std::size_t deepest_nesting = 200;

/// File names live for the whole program, so that positions stay small.
const std::string* intern_file(const std::string& name) {
  static std::mutex mutex;
  static std::set<std::string> names;
  const std::lock_guard lock(mutex);
  return &*names.insert(name).first;
}

std::size_t count_nodes(const Node& node) {
  std::size_t count = 1 + node.keys.size();
  for (const Node& value : node.values) count += count_nodes(value);
  return count;
}

/// Stops the parser when there is no point in reading on; already reported.
struct StopReading {};

/// Builds the tree from yaml-cpp's events. Its own Node is not used: that loses the position of
/// aliases and duplicate keys, and follows self-referring anchors for ever.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string* file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  Node take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    place({Node::Kind::null, position(mark)}, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) {
      diagnostics_.add(position(mark), "an alias cannot stand inside the value its anchor names");
      place({Node::Kind::null, position(mark)}, 0);
      return;
    }
    Node copy = found->second;
    copy.position = position(mark);
    count_ += count_nodes(copy);
    place(std::move(copy), 0);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node{Node::Kind::scalar, position(mark), tag == "!", value};
    if (!node.quoted && (value.empty() || value == "~" || value == "null")) {
      node.kind = Node::Kind::null;
    }
    place(std::move(node), anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open({Node::Kind::list, position(mark)}, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open({Node::Kind::map, position(mark)}, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    Node node;
    YAML::anchor_t anchor;
    bool expects_key = true;
    bool skips_value = false;
    std::unordered_set<std::string> seen = {};
  };

  Position position(const YAML::Mark& mark) const {
    return {file_, mark.line + 1, mark.column + 1};
  }
  void open(Node node, YAML::anchor_t anchor) {
    if (levels_.size() >= deepest_nesting) {
      diagnostics_.add(node.position, fmt::format("nested deeper than {} levels", deepest_nesting));
      throw StopReading{};
    }
    levels_.push_back({std::move(node), anchor});
  }
  void close() {
    Level level = std::move(levels_.back());
    levels_.pop_back();
    place(std::move(level.node), level.anchor);
  }
  void place(Node node, YAML::anchor_t anchor) {
    if (++count_ > most_nodes) {
      diagnostics_.add(node.position,
                       fmt::format("the document unfolds to more than {} values", most_nodes));
      throw StopReading{};
    }
    if (anchor != 0) anchors_[anchor] = node;
    if (levels_.empty()) {
      root_ = std::move(node);
      return;
    }
    Level& level = levels_.back();
    if (level.node.is_list()) {
      level.node.values.push_back(std::move(node));
    } else if (level.expects_key) {
      place_key(level, std::move(node));
    } else {
      level.expects_key = true;
      if (!level.skips_value) level.node.values.push_back(std::move(node));
      level.skips_value = false;
    }
  }
  void place_key(Level& level, Node key) {
    level.expects_key = false;
    level.skips_value = true;
    if (!key.is_scalar()) {
      diagnostics_.add(key.position, "a key must be a word, not " + key.description());
    } else if (!is_new(level, key.text)) {
      diagnostics_.add(key.position, fmt::format("duplicate key '{}'; first given in line {}",
                                                 key.text, first_line(level.node, key.text)));
    } else {
      level.node.keys.push_back(std::move(key));
      level.skips_value = false;
    }
  }
  static bool is_new(Level& level, const std::string& key) {
    constexpr std::size_t few = 16;  // below it a linear search is faster than hashing
    if (level.node.keys.size() < few)
      return std::none_of(level.node.keys.begin(), level.node.keys.end(),
                          [&](const Node& other) { return other.text == key; });
    if (level.seen.empty())
      for (const Node& other : level.node.keys) level.seen.insert(other.text);
    return level.seen.insert(key).second;
  }
  static int first_line(const Node& map, const std::string& key) {
    for (const Node& other : map.keys)
      if (other.text == key) return other.position.line;
    return 0;
  }

  const std::string* file_;
  Diagnostics& diagnostics_;
  Node root_;
  std::vector<Level> levels_;
  std::unordered_map<YAML::anchor_t, Node> anchors_;
  std::size_t count_ = 0;
};

}  // namespace

std::string format_diagnostic(const Diagnostic& diagnostic) {
  const std::string file = diagnostic.position.file != nullptr ? *diagnostic.position.file : "";
  if (diagnostic.position.line == 0) return fmt::format("{}: {}", file, diagnostic.message);
  return fmt::format("{}:{}:{}: {}", file, diagnostic.position.line, diagnostic.position.column,
                     diagnostic.message);
}

std::vector<Diagnostic> Diagnostics::sorted() const {
  const auto key = [](const Diagnostic& d) {
    return std::tuple(d.position.file != nullptr ? std::string_view(*d.position.file) : "",
                      d.position.line, d.position.column, std::string_view(d.message));
  };
  std::vector<Diagnostic> result = list_;
  std::stable_sort(result.begin(), result.end(),
                   [&](const Diagnostic& a, const Diagnostic& b) { return key(a) < key(b); });
  result.erase(
      std::unique(result.begin(), result.end(),
                  [&](const Diagnostic& a, const Diagnostic& b) { return key(a) == key(b); }),
      result.end());
  return result;
}

const Node* Node::find(std::string_view key) const {
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i].text == key) return &values[i];
  return nullptr;
}

std::string Node::description() const {
  switch (kind) {
    case Kind::null:
      return "nothing";
    case Kind::list:
      return "a list";
    case Kind::map:
      return "a map";
    case Kind::scalar:
      break;
  }
  constexpr std::size_t longest = 40;
  return "'" + (text.size() > longest ? text.substr(0, longest) + "..." : text) + "'";
}

Node parse_document(std::string_view text, const std::string& file, Diagnostics& diagnostics) {
  const std::string* name = intern_file(file);
  TreeBuilder builder(name, diagnostics);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) return {Node::Kind::null, {name, 1, 1}};
  } catch (const YAML::Exception& error) {
    diagnostics.add({name, error.mark.line + 1, error.mark.column + 1},
                    "YAML syntax: " + error.msg);
    return {Node::Kind::null, {name, 1, 1}};
  } catch (const StopReading&) {
    return {Node::Kind::null, {name, 1, 1}};
  }
  return builder.take();
}

Node read_document(const std::filesystem::path& path, Diagnostics& diagnostics) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  std::error_code ignored;
  if (!stream || std::filesystem::is_directory(path, ignored) || !(text << stream.rdbuf())) {
    const std::string* name = intern_file(path.string());
    diagnostics.add({name, 0, 0}, "the file cannot be read");
    return {Node::Kind::null, {name, 0, 0}};
  }
  return parse_document(text.str(), path.string(), diagnostics);
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  // Levenshtein distance; near means at most a third of the letters wrong.
  const std::string* best = nullptr;
  std::size_t best_distance = std::max<std::size_t>(1, name.size() / 3) + 1;
  std::vector<std::size_t> row;
  for (const std::string& candidate : candidates) {
    row.resize(candidate.size() + 1);
    for (std::size_t j = 0; j <= candidate.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= name.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t above = row[j];
        row[j] = std::min(
            {above + 1, row[j - 1] + 1, diagonal + (name[i - 1] == candidate[j - 1] ? 0 : 1)});
        diagonal = above;
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = &candidate;
    }
  }
  return best == nullptr ? "" : fmt::format("; did you mean '{}'?", *best);
}

}  // namespace ilss
