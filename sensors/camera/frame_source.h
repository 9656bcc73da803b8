// Where a camera's images come from, apart from simulation: files, a video, a device.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "framework/module/outcome.h"
#include "framework/module/output.h"

namespace ilss {

/// Exactly one of these is given.
struct FrameRequest {
  std::vector<std::filesystem::path> images = {};  ///< files, or folders taken in order of name
  std::optional<std::filesystem::path> video = {};
  std::optional<std::int64_t> device = {};
};

/// A sequence of grey images.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;

  /// Reads the next image's grey levels, of shape {rows, columns}. Faults:
  /// `end_of_data`, `bad_data` (a file that holds no image), `device_lost` (a file, folder or
  /// device that cannot be opened, or stopped).
  virtual Outcome<> next(Samples& samples) = 0;
};

/// Opens images, a video or a device. The first call loads libilss_opencv from beside this library,
/// so that systems without a real camera start without OpenCV. Faults: `device_lost`.
Outcome<std::unique_ptr<FrameSource>> open_frames(const FrameRequest& request);

}  // namespace ilss
