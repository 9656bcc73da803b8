// Reads graphs out of tests' texts and files.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "framework/graph/system.h"
#include "tests/framework/graph/test_modules.h"

namespace ilss::test {

/// What is wrong, a line each.
inline std::string messages(const Diagnostics& diagnostics) {
  std::string text;
  for (const Diagnostic& d : diagnostics.sorted()) text += format_diagnostic(d) + "\n";
  return text;
}

/// A plan, or what is wrong with the graph.
struct Read {
  std::optional<Plan> plan;
  std::string errors;
};

inline Read read_text(const std::string& text, const std::vector<std::string>& sets = {},
                      const std::filesystem::path& directory = ".") {
  Diagnostics diagnostics;
  std::vector<Override> overrides;
  for (const std::string& set : sets)
    if (auto o = parse_override(set, "--set", diagnostics)) overrides.push_back(std::move(*o));
  const Node graph = parse_document(text, "graph.yaml", diagnostics);
  Read read;
  read.plan = build_plan(graph, directory, registry(), overrides, diagnostics);
  read.errors = messages(diagnostics);
  return read;
}

/// The plan of a graph that must be right.
inline Plan plan_of(const std::string& text, const std::vector<std::string>& sets = {},
                    const std::filesystem::path& directory = ".") {
  Read read = read_text(text, sets, directory);
  EXPECT_EQ(read.errors, "");
  if (!read.plan) throw std::runtime_error("no plan:\n" + read.errors);
  return std::move(*read.plan);
}

/// A folder of files that goes with the test.
class Folder {
 public:
  Folder() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string("ilss_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
  }

 private:
  std::filesystem::path path_;
};

inline const Estimate& output_of(const System& system, std::size_t i = 0) {
  return system.node(system.plan().outputs.at(i)).output().estimate;
}

inline const Estimate& estimate_of(const System& system, const std::string& node) {
  return system.node(system.plan().find(node).value()).output().estimate;
}

/// The owners' names that an estimate's budget blames.
inline std::vector<std::string> blamed(const Plan& plan, const Lineage& lineage) {
  std::vector<std::string> names;
  for (const Source& source : lineage.sources())
    if (names.empty() || names.back() != plan.owners.at(source.owner).name)
      names.push_back(plan.owners.at(source.owner).name);
  return names;
}

}  // namespace ilss::test
