// `ilss graph`: a graph's network as a picture.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "framework/graph/dot.h"
#include "framework/report/estimate_json.h"
#include "src/session.h"

namespace ilss {
namespace {

struct GraphOptions {
  std::string graph;
  std::vector<std::string> sets;
  std::string format = "dot";
  std::string output;
  bool json = false;
};

/// A file that is gone when it goes out of scope.
class TemporaryFile {
 public:
  TemporaryFile() {
    path_ = (std::filesystem::temp_directory_path() / "ilss_graph_XXXXXX").string();
    descriptor_ = mkstemp(path_.data());
    if (descriptor_ < 0)
      fail(exit_failed, fmt::format("cannot write to '{}': {}", path_, std::strerror(errno)));
  }
  ~TemporaryFile() {
    close(descriptor_);
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::string& path() const { return path_; }
  std::string read() const {
    std::ifstream stream(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

 private:
  std::string path_;
  int descriptor_;
};

/// Draws DOT text with Graphviz's `dot`.
std::string draw_svg(const std::string& dot) {
  const TemporaryFile input;
  const TemporaryFile output;
  std::ofstream(input.path(), std::ios::binary) << dot;
  std::string program = "dot";
  std::string type = "-Tsvg";
  std::string into = "-o" + output.path();
  std::string from = input.path();
  std::array<char*, 5> arguments = {program.data(), type.data(), into.data(), from.data(), nullptr};
  pid_t process = 0;
  const int error =
      posix_spawnp(&process, program.c_str(), nullptr, nullptr, arguments.data(), environ);
  if (error == ENOENT)
    fail(exit_failed,
         "drawing needs Graphviz's 'dot', which is not installed (Debian package "
         "graphviz); --format dot does without");
  if (error != 0) fail(exit_failed, fmt::format("cannot start 'dot': {}", std::strerror(error)));
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    fail(exit_failed, "Graphviz's 'dot' could not draw the graph");
  return output.read();
}

void write(const std::string& text, const std::string& file) {
  if (file.empty()) {
    fmt::print("{}", text);
    return;
  }
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) fail(exit_failed, fmt::format("cannot write '{}'", file));
}

}  // namespace

void add_graph(Verb command, Session& session) {
  auto options = std::make_shared<GraphOptions>();
  Verb verb = command.add_verb("graph", "Draw a graph's network as DOT or SVG");
  verb.add_option("GRAPH", options->graph, "The graph's YAML file").required();
  verb.add_set_option(options->sets);
  verb.add_option("--format", options->format, "dot, or svg (drawn by Graphviz)")
      .one_of({"dot", "svg"})
      .show_default();
  verb.add_option("--output", options->output, "Write to a file instead").type_name("FILE");
  verb.add_flag("--json", options->json, "Print JSON: {format, text}");
  verb.on_call([options, &session] {
    check_output_file("--output", options->output, {options->graph});
    session.load_modules();
    const Plan plan = session.read_graph(options->graph, options->sets);
    const std::string dot = to_dot(plan);
    const std::string text = options->format == "svg" ? draw_svg(dot) : dot;
    write(options->json ? json_text({{"format", options->format}, {"text", text}}, true) + "\n"
                        : text,
          options->output);
  });
}

}  // namespace ilss
