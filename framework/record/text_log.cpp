#include "framework/record/text_log.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <system_error>

namespace ilss {
namespace {

constexpr std::size_t longest_log = std::size_t{1} << 30;  // bytes

Fault unreadable_log(std::string message) { return {FaultKind::device_lost, std::move(message)}; }

Outcome<std::string> read_unzipped(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return unreadable_log(error
                              ? fmt::format("cannot read '{}': {}", path.string(), error.message())
                              : fmt::format("'{}' is not a regular file", path.string()));
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (file == nullptr) return unreadable_log(fmt::format("cannot read '{}'", path.string()));
  std::string text;
  std::string block(std::size_t{1} << 16, '\0');
  for (;;) {
    const int count = gzread(file.get(), block.data(), static_cast<unsigned>(block.size()));
    if (count < 0)
      return unreadable_log(
          fmt::format("cannot read '{}': the compressed data are damaged", path.string()));
    if (count == 0) break;
    text.append(block, 0, static_cast<std::size_t>(count));
    if (text.size() > longest_log)
      return unreadable_log(fmt::format("'{}' is longer than 1 GB", path.string()));
  }
  int code = Z_OK;
  gzerror(file.get(), &code);
  if (code != Z_OK)
    return unreadable_log(
        fmt::format("cannot read '{}': the compressed data end early", path.string()));
  if (text.find('\0') != std::string::npos)
    return unreadable_log(
        fmt::format("'{}' holds binary data; expected the lines of a log", path.string()));
  if (text.empty()) return unreadable_log(fmt::format("'{}' is empty", path.string()));
  return text;
}

}  // namespace

Outcome<std::shared_ptr<const TextLog>> TextLog::open(const std::filesystem::path& path) {
  // Remembers only files that somebody still holds, so a file changed between runs is read anew.
  static std::mutex mutex;
  static std::map<std::filesystem::path, std::weak_ptr<const TextLog>> held;
  const std::lock_guard lock(mutex);
  if (auto log = held[path].lock()) return log;
  auto text = read_unzipped(path);
  if (!text) return text.fault();
  auto log = std::make_shared<TextLog>();
  log->text_ = std::move(*text);
  for (std::size_t begin = 0; begin < log->text_.size();) {
    log->begins_.push_back(begin);
    begin = std::min(log->text_.find('\n', begin), log->text_.size() - 1) + 1;
  }
  held[path] = log;
  return std::shared_ptr<const TextLog>(log);
}

std::string_view TextLog::line(std::size_t i) const {
  const std::size_t end = i + 1 < begins_.size() ? begins_[i + 1] : text_.size();
  std::string_view line = std::string_view(text_).substr(begins_[i], end - begins_[i]);
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  return line;
}

}  // namespace ilss
