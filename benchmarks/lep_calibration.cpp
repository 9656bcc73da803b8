// How well the LEP sensor's calibration does: both methods on simulated calibrations of single
// noisy readings, 256 scan angles by 40 depths. What docs/lep.md says of it is printed here.
// Claims: the fit's errors are as large as it says, and it takes less than 100 ms. Run:
// build/release/bin/lep_calibration [--calibrations N] [--seed S] With --example FOLDER it writes
// graphs/data/lep_calibration.csv and lep_stripes.csv instead.
#include <fmt/format.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "framework/estimate/consistency.h"
#include "framework/estimate/random.h"
#include "sensors/lep/lep_calibration_data.h"
#include "sensors/lep/lep_table.h"

namespace ilss::benchmarks {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// Errors of one parameter over all calibrations.
struct ErrorSum {
  double sum = 0;
  double squares = 0;
  double largest = 0;
  void add(double error) {
    sum += error;
    squares += error * error;
    largest = std::max(largest, std::abs(error));
  }
};

std::array<double, 4> numbers(const LepGeometry<double>& g) {
  return {g.focal_length, g.baseline, g.vergence, g.lens_distance};
}

void print_errors(const char* method, const std::array<ErrorSum, 4>& errors, double n) {
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const bool angle = lep_calibration_units[i] == "rad";
    const double scale = angle ? 1 / degree : 1e3;
    fmt::print("{:<10} {:<14} {:<4} {:>10.5f} {:>10.5f} {:>10.5f}\n", i == 0 ? method : "",
               lep_calibration_names[i], angle ? "deg" : "mm", scale * errors[i].sum / n,
               scale * std::sqrt(errors[i].squares / n), scale * errors[i].largest);
  }
}

/// tan gamma as x2 / x1, which is as right as x5 / x4 on exact data.
double other_vergence(const LepLinearFit& fit) {
  return std::atan(fit.unknowns[1] / fit.unknowns[0]);
}

void tabulate(std::size_t calibrations, std::uint64_t seed) {
  const LepCalibrationDesign design;
  const auto truth = numbers(design.geometry);
  std::array<ErrorSum, 4> linear;
  std::array<ErrorSum, 4> fitted;
  ErrorSum other;
  ConsistencyStatistic nees_of_fit;
  double chi_squared = 0;
  std::vector<double> times;
  LepCalibration last;
  for (std::size_t run = 0; run < calibrations; ++run) {
    const auto points = simulate_lep_calibration(design, seed + run);
    const auto start = std::chrono::steady_clock::now();
    const auto result = calibrate_lep(points, design.origin);
    times.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    if (!result || !result->linear) {
      fmt::print("seed {}: {}\n", seed + run,
                 result ? "the paper's method gave nothing" : result.fault().message);
      continue;
    }
    last = *result;
    Eigen::Vector4d error;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      linear[i].add(numbers(result->linear->geometry)[i] - truth[i]);
      error[static_cast<Eigen::Index>(i)] = numbers(result->geometry)[i] - truth[i];
      fitted[i].add(error[static_cast<Eigen::Index>(i)]);
    }
    other.add(other_vergence(*result->linear) - truth[2]);
    nees_of_fit.add(normalized_squared_error(error, result->covariance.topLeftCorner<4, 4>()));
    chi_squared += result->chi_squared / result->degrees_of_freedom();
  }
  const auto n = static_cast<double>(nees_of_fit.count());
  fmt::print("{} calibrations of {} x {} single readings, seeds from {}\n\n", calibrations,
             design.angles, design.depths, seed);
  fmt::print("{:<10} {:<14} {:<4} {:>10} {:>10} {:>10}\n", "method", "parameter", "", "mean error",
             "rms error", "largest");
  print_errors("linear", linear, n);
  fmt::print("{:<10} {:<14} {:<4} {:>10.5f} {:>10.5f} {:>10.5f}\n", "  by x2/x1", "vergence", "deg",
             other.sum / n / degree, std::sqrt(other.squares / n) / degree, other.largest / degree);
  print_errors("fit", fitted, n);
  const Interval bounds = nees_of_fit.bounds(0.99);
  fmt::print("\nstated sd of the fit: {:.5f} mm, {:.5f} mm, {:.5f} deg, {:.5f} mm\n",
             1e3 * std::sqrt(last.covariance(0, 0)), 1e3 * std::sqrt(last.covariance(1, 1)),
             std::sqrt(last.covariance(2, 2)) / degree, 1e3 * std::sqrt(last.covariance(3, 3)));
  fmt::print("NEES per degree of freedom {:.3f}, 99 % bounds {:.3f} .. {:.3f}\n",
             nees_of_fit.mean(), bounds.low, bounds.high);
  fmt::print("mean chi-squared per degree of freedom {:.4f}\n", chi_squared / n);
  std::sort(times.begin(), times.end());
  fmt::print("time of both methods: median {:.1f} ms, longest {:.1f} ms\n",
             1e3 * times[times.size() / 2], 1e3 * times.back());
}

/// What interpolation in a table of that many depths does, and single readings in it.
void tabulate_tables(std::uint64_t seed) {
  fmt::print("\n{:>6} {:>14} {:>14} {:>18} {:>14}\n", "depths", "rms error", "largest",
             "rms, with noise", "cells lost");
  for (const std::size_t depths : {10, 20, 40, 80}) {
    LepCalibrationDesign design;
    design.depths = depths;
    const auto table = LepTable::make(simulate_lep_calibration(design, seed));
    if (!table) continue;
    const LepTableError alone = interpolation_error(*table, design.geometry, design.origin);
    const LepTableError noisy = table_error(*table, design.geometry, design.origin);
    fmt::print("{:>6} {:>11.3f} mm {:>11.3f} mm {:>15.3f} mm {:>12.1f} %\n", depths,
               1e3 * alone.rms, 1e3 * alone.largest, 1e3 * noisy.rms,
               100 - 100 * static_cast<double>(noisy.inverted) / static_cast<double>(noisy.cells));
  }
}

/// A small calibration of the shipped sensor, mounted off the head's axis.
void write_example(const std::string& folder, std::uint64_t seed) {
  LepCalibrationDesign design;
  design.angles = 32;
  design.depths = 12;
  design.origin = {-0.043, 0.06, 0.5 * degree, Eigen::Matrix3d::Zero()};
  const std::string truth =
      "f 50 mm, d 86 mm, gamma 7.07 deg, s 60 mm; the laser turns at x -43 mm, z 60 mm,\n"
      "# projected vergence 0.5 deg";
  auto data = fmt::output_file(folder + "/lep_calibration.csv");
  data.print(
      "# Simulated z calibration of the shipped LEP sensor by build/release/bin/"
      "lep_calibration --example\n"
      "# (seed {}): {}. One reading each, noise current 36.2 pA.\n"
      "scan_angle [deg],depth [m],image_position [um],detector_current [nA]\n",
      seed, truth);
  for (const LepCalibrationPoint& point : simulate_lep_calibration(design, seed))
    data.print("{:.4f},{:.4f},{:.3f},{:.4f}\n", point.scan_angle / degree, point.depth,
               1e6 * point.image_position, 1e9 * design.current(point.depth - design.origin.z));
  auto stripes = fmt::output_file(folder + "/lep_stripes.csv");
  stripes.print(
      "# Simulated x calibration of the same sensor (seed {}): stripe edges every 50 mm on "
      "a flat\n# target at three depths, scan angles with an sd of 0.01 deg.\n"
      "scan_angle [deg],x [mm],z [mm]\n",
      seed);
  RandomBits random(derive_seed(seed, "lep stripes"));
  for (const double z : {0.6, 1.2, 2.0}) {
    for (int edge = -14; edge <= 14; ++edge) {
      const double x = 0.05 * edge;
      const double angle =
          std::atan2(x - design.origin.x, z - design.origin.z) - design.origin.projected_vergence;
      if (std::abs(angle) > design.half_field) continue;
      stripes.print("{:.4f},{:.0f},{:.0f}\n", angle / degree + 0.01 * draw_normal(random), 1e3 * x,
                    1e3 * z);
    }
  }
}

}  // namespace
}  // namespace ilss::benchmarks

int main(int argc, char** argv) {
  CLI::App app{"Errors and time of the LEP sensor's calibration"};
  std::size_t calibrations = 200;
  std::uint64_t seed = 1;
  std::string folder;
  app.add_option("--calibrations", calibrations, "How many to simulate")
      ->check(CLI::Range(1, 100000));
  app.add_option("--seed", seed, "Of the first one");
  app.add_option("--example", folder, "Write the example data set into this folder");
  CLI11_PARSE(app, argc, argv);
  if (!folder.empty()) {
    ilss::benchmarks::write_example(folder, seed);
    return 0;
  }
  ilss::benchmarks::tabulate(calibrations, seed);
  ilss::benchmarks::tabulate_tables(seed);
  return 0;
}
