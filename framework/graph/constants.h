// A graph's constants: named values of limited accuracy. One name is one source of error.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "framework/graph/value_reader.h"

namespace ilss {

/// One number of a constant, with its error as columns of the constant's owner, in its unit.
struct ConstantElement {
  WrittenQuantity quantity;
  std::uint32_t owner = 0;
  std::vector<double> factor = {};  ///< sensitivity to columns 0, 1, ... of the owner
};

/// The constants of one graph by name; elements of vectors are "name.element".
class Constants {
 public:
  /// Reads the map under `constants:`; new owners go to `owners` as `prefix + name`. A constant may
  /// refer to one of `outer` ("$name"), and then is the same source.
  void read(const Node& map, const std::string& prefix, const std::filesystem::path& directory,
            const Constants* outer, SourceOwners& owners, Diagnostics& diagnostics);

  const ConstantElement* find(std::string_view name) const;
  /// Complains that there is no constant of that name, with a suggestion; silent where there is one
  /// that could not be read.
  void report_unknown(const Node& reference, Diagnostics& diagnostics) const;

 private:
  /// Makes `name` the same source, or vector of sources, as a constant of `outer`.
  void refer(const std::string& name, const Node& reference, const Constants* outer,
             Diagnostics& diagnostics);
  void read_one(const std::string& name, const Node& value, const std::string& prefix,
                SourceOwners& owners, Diagnostics& diagnostics);
  /// Makes a value a constant, with a source of its own where it has an error.
  void keep(const std::string& name, WrittenQuantity quantity, const std::string& prefix,
            SourceOwners& owners, Diagnostics& diagnostics);
  void read_vector(const std::string& name, const Node& map, const std::string& prefix,
                   SourceOwners& owners, Diagnostics& diagnostics);

  std::map<std::string, ConstantElement, std::less<>> elements_;
  std::set<std::string, std::less<>> unread_;  ///< what is wrong with them has been said
};

}  // namespace ilss
