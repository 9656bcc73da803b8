// YAML text as a tree that knows where each value stands, and the list of what is wrong with it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace ilss {

/// A place in a file; lines and columns count from 1. Line 0: the file as a whole.
struct Position {
  const std::string* file = nullptr;  ///< lives as long as the program
  int line = 0;
  int column = 0;
};

/// What is wrong, and where.
struct Diagnostic {
  Position position;
  std::string message;
};

/// "file:line:column: message", "file: message" for a file as a whole, the message where there is
/// no file.
std::string format_diagnostic(const Diagnostic& diagnostic);

/// Collects everything that is wrong, so that all of it can be reported in one go.
class Diagnostics {
 public:
  void add(Position position, std::string message) {
    list_.push_back({position, std::move(message)});
  }
  bool empty() const { return list_.empty(); }
  std::size_t size() const { return list_.size(); }
  /// By file and position; equal ones once.
  std::vector<Diagnostic> sorted() const;

 private:
  std::vector<Diagnostic> list_;
};

/// A value in a YAML document. Aliases stand as copies of what their anchors name, with the alias's
/// own position.
struct Node {
  enum class Kind { null, scalar, list, map };

  Kind kind = Kind::null;
  Position position = {};
  bool quoted = false;            ///< a scalar in quotes
  std::string text = {};          ///< of a scalar
  std::vector<Node> keys = {};    ///< of a map, scalars
  std::vector<Node> values = {};  ///< of a map or list

  bool is_scalar() const { return kind == Kind::scalar; }
  bool is_list() const { return kind == Kind::list; }
  bool is_map() const { return kind == Kind::map; }
  bool is_null() const { return kind == Kind::null; }
  std::size_t size() const { return values.size(); }
  /// The value of a map's key, or null.
  const Node* find(std::string_view key) const;
  /// "a list", "a map", "'text'", "nothing": for messages.
  std::string description() const;
};

/// Reads one YAML document. Syntax errors, control characters, a second document, duplicate keys,
/// keys that are not scalars, aliases of unknown or enclosing anchors and documents that unfold to
/// more than a million values or 200 levels go to `diagnostics`; what could be read is returned.
/// `file` is the name to report positions under.
Node parse_document(std::string_view text, const std::string& file, Diagnostics& diagnostics);

/// As above from a file; one that cannot be read is a diagnostic.
Node read_document(const std::filesystem::path& path, Diagnostics& diagnostics);

/// "; did you mean 'x'?" where one of `candidates` is nearly `name`, else "".
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace ilss
