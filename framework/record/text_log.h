// The lines of a log, plain or compressed.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/module/outcome.h"

namespace ilss {

/// The lines of a text file, plain or compressed by gzip, read once and shared.
class TextLog {
 public:
  /// Faults: device_lost where the file cannot be read, is empty, binary or longer than 1 GB.
  static Outcome<std::shared_ptr<const TextLog>> open(const std::filesystem::path& path);
  std::size_t lines() const { return begins_.size(); }
  std::string_view line(std::size_t i) const;

 private:
  std::string text_;
  std::vector<std::size_t> begins_;
};

}  // namespace ilss
