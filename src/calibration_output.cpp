#include "src/calibration_output.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "src/session.h"

namespace ilss {

void refuse(const std::string& file, const Fault& fault) {
  fmt::print(stderr, "{}: {}: {}\n", file, fault_name(fault.kind), fault.message);
  throw Exit{exit_bad_input};
}

void write_file(const std::string& output, const std::string& text) {
  if (output.empty()) return;
  std::error_code ignored;
  const std::string path = std::filesystem::weakly_canonical(output, ignored).string();
  const std::string partial = path + ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(partial, path, error);
  if (stream && !error) return;
  const std::string reason = error ? error.message() : std::strerror(errno);
  std::filesystem::remove(partial, error);
  fail(exit_failed, fmt::format("cannot write '{}': {}", path, reason));
}

}  // namespace ilss
