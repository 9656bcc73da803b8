// Images, videos and devices through OpenCV; a library of its own, loaded by open_frames.
#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <utility>

#include "sensors/camera/frame_source.h"
#include "sensors/camera/image.h"

namespace ilss {
namespace {

void copy_levels(const cv::Mat& grey, Samples& samples) {
  const auto levels = make_levels(samples, static_cast<std::size_t>(grey.rows),
                                  static_cast<std::size_t>(grey.cols));
  for (int row = 0; row < grey.rows; ++row)
    std::copy_n(grey.ptr<std::uint8_t>(row), grey.cols,
                levels.begin() + static_cast<std::ptrdiff_t>(row) * grey.cols);
}

/// Files in the order given, folders' files in order of name.
class ImageFiles final : public FrameSource {
 public:
  explicit ImageFiles(std::vector<std::filesystem::path> paths) : paths_(std::move(paths)) {}

  Outcome<> next(Samples& samples) override {
    if (!expanded_) {
      if (auto outcome = expand_folders(); !outcome) return outcome;
      expanded_ = true;
    }
    if (position_ == paths_.size()) return Fault{FaultKind::end_of_data, "no image is left"};
    const std::string path = paths_[position_++].string();
    if (!std::filesystem::exists(path))
      return Fault{FaultKind::device_lost, "cannot open '" + path + "': there is no such file"};
    const cv::Mat grey = cv::imread(path, cv::IMREAD_GRAYSCALE);
    if (grey.empty())
      return Fault{FaultKind::bad_data, "'" + path + "' is not an image that can be read"};
    copy_levels(grey, samples);
    return {};
  }

 private:
  Outcome<> expand_folders() {
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& path : paths_) {
      if (!std::filesystem::is_directory(path)) {
        files.push_back(path);
        continue;
      }
      std::error_code error;
      std::filesystem::directory_iterator entries(path, error);
      if (error)
        return Fault{FaultKind::device_lost,
                     "cannot read the folder '" + path.string() + "': " + error.message()};
      const std::size_t first = files.size();
      for (const auto& entry : entries)
        if (entry.is_regular_file() && !entry.path().filename().string().starts_with("."))
          files.push_back(entry.path());
      std::sort(files.begin() + static_cast<std::ptrdiff_t>(first), files.end());
    }
    paths_ = std::move(files);
    return {};
  }

  std::vector<std::filesystem::path> paths_;
  std::size_t position_ = 0;
  bool expanded_ = false;
};

/// A video file or a device.
class Capture final : public FrameSource {
 public:
  explicit Capture(const std::filesystem::path& video)
      : name_("the video '" + video.string() + "'"), end_(FaultKind::end_of_data) {
    if (std::filesystem::exists(video)) capture_.open(video.string());
  }
  explicit Capture(std::int64_t device)
      : name_("camera device " + std::to_string(device)), end_(FaultKind::device_lost) {
    capture_.open(static_cast<int>(device));
  }

  Outcome<> next(Samples& samples) override {
    if (!capture_.isOpened()) return Fault{FaultKind::device_lost, "cannot open " + name_};
    if (!capture_.read(frame_) || frame_.empty()) return Fault{end_, name_ + " gives no more"};
    if (frame_.channels() == 1)
      copy_levels(frame_, samples);
    else {
      cv::cvtColor(frame_, grey_, cv::COLOR_BGR2GRAY);
      copy_levels(grey_, samples);
    }
    return {};
  }

 private:
  std::string name_;
  FaultKind end_;
  cv::VideoCapture capture_;
  cv::Mat frame_;
  cv::Mat grey_;
};

/// Turns OpenCV's exceptions into faults.
class Guarded final : public FrameSource {
 public:
  explicit Guarded(FrameRequest request) : request_(std::move(request)) {}

  Outcome<> next(Samples& samples) override try {
    if (source_ == nullptr) open();
    return source_->next(samples);
  } catch (const std::exception& error) {
    return Fault{FaultKind::bad_data, error.what()};
  }

 private:
  void open() {
    // What goes wrong is said once, as a fault.
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    if (request_.video)
      source_ = std::make_unique<Capture>(*request_.video);
    else if (request_.device)
      source_ = std::make_unique<Capture>(*request_.device);
    else
      source_ = std::make_unique<ImageFiles>(request_.images);
  }

  FrameRequest request_;
  std::unique_ptr<FrameSource> source_;
};

}  // namespace
}  // namespace ilss

extern "C" void ilss_open_frames(const ilss::FrameRequest& request,
                                 std::unique_ptr<ilss::FrameSource>& source) {
  source = std::make_unique<ilss::Guarded>(request);
}
