// Measurements to calibrate by: columns with units of a CSV file.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "framework/module/document.h"

namespace ilss {

/// A column that is wanted: its name and the SI unit that its numbers become.
struct TableColumn {
  std::string_view name;
  std::string_view unit;
  bool positive = false;       ///< numbers that are not are errors
  std::string_view hint = {};  ///< what else can be done where it is missing
  bool optional = false;       ///< where it is missing it is empty
};

/// The wanted columns in their order, in SI units, and where each row stands.
struct CalibrationTable {
  std::vector<std::vector<double>> columns;
  std::vector<Position> rows;
};

/// Reads a CSV file whose header names each column with its unit, as in `image_position [um]`;
/// other columns may stand beside the wanted ones. Missing columns and units, units of another
/// dimension and cells that are no finite numbers go to `diagnostics`.
CalibrationTable read_calibration_table(const std::filesystem::path& path,
                                        std::span<const TableColumn> wanted,
                                        Diagnostics& diagnostics);

}  // namespace ilss
