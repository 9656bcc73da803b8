#include "src/output_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "src/session.h"

namespace ilss {
namespace {

std::string resolved(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(path, ignored).string();
}

}  // namespace

OutputFile::OutputFile(const std::string& path)
    : path_(resolved(path)), partial_(path_ + ".partial"), stream_(partial_, std::ios::binary) {
  if (!stream_) fail_to_write(std::strerror(errno));
}

OutputFile::~OutputFile() {
  stream_.close();
  std::error_code ignored;
  if (!partial_.empty()) std::filesystem::remove(partial_, ignored);
}

void OutputFile::commit() {
  stream_.close();
  if (!stream_) fail_to_write(std::strerror(errno));
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error) fail_to_write(error.message());
  partial_.clear();
}

void OutputFile::fail_to_write(const std::string& reason) const {
  fail(exit_failed, fmt::format("cannot write '{}': {}", path_, reason));
}

}  // namespace ilss
