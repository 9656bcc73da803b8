// A picture as SVG: to scale, with a grid in metres, a legend and 95 % ellipses.
#pragma once

#include <string>

#include "framework/report/picture.h"

namespace ilss {

/// The picture as a file's text. Errors are drawn `error_scale` times as large as they are; the
/// legend says so. What is drawn fits its view; scenes are cut off at its border. Its colours stand
/// out from white and from black.
std::string picture_svg(const Picture& picture, double error_scale);

}  // namespace ilss
