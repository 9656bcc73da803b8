// What all calibrations share: the file that they write, and when they refuse.
#pragma once

#include <string>

#include "framework/module/outcome.h"
#include "src/options.h"

namespace ilss {

/// Errors of more than three times what is stated: then the fit's own errors mean nothing.
inline constexpr double most_chi_squared = 9;  // per degree of freedom

/// Writes the file whole or not at all; through a symbolic link into what it names. Nothing where
/// the name is empty. @throws Exit
void write_file(const std::string& output, const std::string& text);

/// Ends the command: the data make no calibration. @throws Exit
[[noreturn]] void refuse(const std::string& file, const Fault& fault);

/// `ilss calibrate laser`.
void add_calibrate_laser(Verb calibrate);

}  // namespace ilss
