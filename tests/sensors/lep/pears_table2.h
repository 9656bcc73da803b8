// Pears 1997, Table 2, as the tests use it: tests/data/lep/pears_table2.csv in SI units.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "sensors/lep/lep_noise.h"

namespace ilss {

struct PearsRow {
  double range;
  double range_deviation;
  LepNoiseReading noise;
};

inline std::vector<PearsRow> pears_table2() {
  std::ifstream file(std::filesystem::path(ILSS_TEST_DATA) / "lep/pears_table2.csv");
  std::vector<PearsRow> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    char comma = 0;
    double range = 0;
    double deviation = 0;
    double percent = 0;
    double current = 0;
    double position = 0;
    if (cells >> range >> comma >> deviation >> comma >> percent >> comma >> current >> comma >>
        position)
      rows.push_back({range, 1e-2 * deviation, {1e-9 * current, 1e-6 * position}});
  }
  return rows;
}

inline std::vector<LepNoiseReading> pears_noise() {
  std::vector<LepNoiseReading> readings;
  for (const PearsRow& row : pears_table2()) readings.push_back(row.noise);
  return readings;
}

}  // namespace ilss
