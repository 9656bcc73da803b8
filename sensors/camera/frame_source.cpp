#include "sensors/camera/frame_source.h"

#include <dlfcn.h>

#include <string>

namespace ilss {
namespace {

using OpenFunction = void (*)(const FrameRequest&, std::unique_ptr<FrameSource>&);

/// The folder that this library was loaded from.
std::filesystem::path own_folder() {
  Dl_info info;
  if (dladdr(reinterpret_cast<const void*>(&open_frames), &info) == 0 || info.dli_fname == nullptr)
    return {};
  return std::filesystem::path(info.dli_fname).parent_path();
}

/// The library's opener, or why it could not be loaded.
struct Loaded {
  OpenFunction open = nullptr;
  std::string error;
};
Loaded load() {
  const std::string path = (own_folder() / "libilss_opencv.so").string();
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return {nullptr, dlerror()};
  void* symbol = dlsym(library, "ilss_open_frames");
  if (symbol == nullptr) return {nullptr, dlerror()};
  return {reinterpret_cast<OpenFunction>(symbol), {}};
}

}  // namespace

Outcome<std::unique_ptr<FrameSource>> open_frames(const FrameRequest& request) {
  static const Loaded library = load();
  if (library.open == nullptr)
    return Fault{FaultKind::device_lost,
                 "cannot load the library that reads images: " + library.error};
  std::unique_ptr<FrameSource> source;
  library.open(request, source);
  return source;
}

}  // namespace ilss
