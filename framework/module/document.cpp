#include "framework/module/document.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
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

/// How large a value is: itself and all that it holds, and how deeply that is nested.
struct Extent {
  std::size_t nodes = 1;
  std::size_t depth = 1;
};

Extent extent(const Node& node) {
  Extent result;
  result.nodes += node.keys.size();
  for (const Node& value : node.values) {
    const Extent inner = extent(value);
    result.nodes += inner.nodes;
    result.depth = std::max(result.depth, inner.depth + 1);
  }
  return result;
}

/// YAML allows no control characters, and yaml-cpp takes one of them (0x04) for the end of the
/// file. Tells where the first one stands.
std::optional<Position> find_control_character(std::string_view text, const std::string* file) {
  Position position{file, 1, 1};
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte < 0x20 && c != '\t' && c != '\n' && c != '\r') || byte == 0x7f) return position;
    ++position.column;
    if (c == '\n') position = {file, position.line + 1, 1};
  }
  return std::nullopt;
}

/// Stops the parser when there is no point in reading on; already reported.
struct StopReading {};

/// Builds the tree from yaml-cpp's events. Its own Node is not used: that loses the position of
/// aliases and duplicate keys, and follows self-referring anchors for ever.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string* file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics), root_{Node::Kind::null, {file, 1, 1}} {}

  Node take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ == 1) return;
    diagnostics_.add(position(mark), "a second document begins here; a file holds one");
    throw StopReading{};
  }
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
    // Before copying, so that what unfolds without end costs nothing.
    const Extent size = extent(found->second);
    check_depth(levels_.size() + size.depth, position(mark));
    check_count(size.nodes, position(mark));
    Node copy = found->second;
    copy.position = position(mark);
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
  void check_depth(std::size_t depth, Position where) {
    if (depth <= deepest_nesting) return;
    diagnostics_.add(where, fmt::format("nested deeper than {} levels", deepest_nesting));
    throw StopReading{};
  }
  void check_count(std::size_t more, Position where) {
    count_ += more;
    if (count_ <= most_nodes) return;
    diagnostics_.add(where, fmt::format("the document unfolds to more than {} values", most_nodes));
    throw StopReading{};
  }
  void open(Node node, YAML::anchor_t anchor) {
    check_depth(levels_.size() + 1, node.position);
    levels_.push_back({std::move(node), anchor});
  }
  void close() {
    Level level = std::move(levels_.back());
    levels_.pop_back();
    place(std::move(level.node), level.anchor);
  }
  void place(Node node, YAML::anchor_t anchor) {
    check_count(1, node.position);
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
    } else if (!is_unused_key(level, key.text)) {
      diagnostics_.add(key.position, fmt::format("duplicate key '{}'; first given in line {}",
                                                 key.text, first_line(level.node, key.text)));
    } else {
      level.node.keys.push_back(std::move(key));
      level.skips_value = false;
    }
  }
  static bool is_unused_key(Level& level, const std::string& key) {
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
  int documents_ = 0;
};

}  // namespace

std::string format_diagnostic(const Diagnostic& diagnostic) {
  if (diagnostic.position.file == nullptr) return diagnostic.message;
  const std::string& file = *diagnostic.position.file;
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
  if (const auto position = find_control_character(text, name)) {
    diagnostics.add(*position, "a control character; a YAML file holds text in UTF-8");
    return {Node::Kind::null, {name, 1, 1}};
  }
  TreeBuilder builder(name, diagnostics);
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) continue;
  } catch (const YAML::Exception& error) {
    diagnostics.add({name, error.mark.line + 1, error.mark.column + 1},
                    "YAML syntax: " + error.msg);
  } catch (const StopReading&) {  // the reason is among the diagnostics
  }
  return builder.take();
}

Node read_document(const std::filesystem::path& path, Diagnostics& diagnostics) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code ignored;
  if (!stream || std::filesystem::is_directory(path, ignored)) {
    const std::string* name = intern_file(path.string());
    diagnostics.add({name, 0, 0}, "the file cannot be read");
    return {Node::Kind::null, {name, 0, 0}};
  }
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return parse_document(text, path.string(), diagnostics);
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  // Letters missing, added, wrong or swapped with their neighbour (optimal string alignment); near
  // means at most a third of the letters, or one of two.
  const std::size_t most = name.size() < 2 ? 0 : std::max<std::size_t>(1, name.size() / 3);
  const std::string* best = nullptr;
  std::size_t best_distance = most + 1;
  std::vector<std::size_t> before_last;
  std::vector<std::size_t> last;
  std::vector<std::size_t> row;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > name.size() + most || name.size() > candidate.size() + most) continue;
    row.resize(candidate.size() + 1);
    last.resize(row.size());
    before_last.resize(row.size());
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= name.size(); ++i) {
      before_last.swap(last);
      last.swap(row);
      row[0] = i;
      for (std::size_t j = 1; j < row.size(); ++j) {
        const std::size_t wrong = name[i - 1] == candidate[j - 1] ? 0 : 1;
        row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + wrong});
        if (i > 1 && j > 1 && name[i - 1] == candidate[j - 2] && name[i - 2] == candidate[j - 1])
          row[j] = std::min(row[j], before_last[j - 2] + 1);
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
