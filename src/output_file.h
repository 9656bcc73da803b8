// A file that a command writes whole or not at all.
#pragma once

#include <fstream>
#include <string>

namespace ilss {

/// Gathers what is written beside the file, under its name with `.partial` added, and puts it in
/// the file's place when it is complete; through a symbolic link into what that names.
class OutputFile {
 public:
  /// Fails with exit status 1 where the partial file cannot be written. @throws Exit
  explicit OutputFile(const std::string& path);
  /// What was not committed is gone, and the file is as it was.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  std::ostream& stream() { return stream_; }
  /// Puts what was written in its place. @throws Exit with status 1 where that fails.
  void commit();

 private:
  [[noreturn]] void fail_to_write(const std::string& reason) const;

  std::string path_;
  std::string partial_;
  std::ofstream stream_;
};

}  // namespace ilss
