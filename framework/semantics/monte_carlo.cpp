#include "framework/semantics/monte_carlo.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>

#include "framework/estimate/consistency.h"
#include "framework/semantics/error_draws.h"
#include "framework/semantics/principal_axes.h"

namespace ilss {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The offsets of one output from its first-order value in every trial, NaN in those without one.
struct Offsets {
  std::vector<std::vector<double>> components;
  std::size_t first_fault = std::numeric_limits<std::size_t>::max();
  std::string fault = {};
};

class Trials {
 public:
  Trials(const System& system, std::size_t trials, std::uint64_t seed)
      : draws_(system.plan().owners, seed), trials_(trials), seed_(seed) {
    for (const std::size_t node : system.plan().outputs) {
      const bool there = system.node(node).outcome.has_output();
      const std::size_t dimension = there ? system.node(node).output().estimate.dimension() : 0;
      outputs_.emplace_back().components.assign(dimension, std::vector<double>(trials));
    }
  }

  std::size_t blocks() const { return (trials_ + ErrorDraws::block - 1) / ErrorDraws::block; }
  std::vector<Offsets>& outputs() { return outputs_; }
  /// What one thread works with, and what it found beside the offsets.
  struct Desk {
    std::vector<double> errors = {};
    std::vector<double> offset = {};
    /// The first trial without an output, of each output, and why.
    std::vector<std::pair<std::size_t, std::string>> first_faults = {};
  };
  Desk desk() const {
    return {.first_faults = {outputs_.size(), {std::numeric_limits<std::size_t>::max(), ""}}};
  }

  /// Does a block's trials; blocks may be done side by side, each with a perturbation of its own
  /// whose targets are the outputs.
  void run(std::size_t block, Perturbation& perturbation, Desk& desk) {
    draws_.fill(perturbation.sources(), block, desk.errors);
    const std::size_t count = perturbation.sources().size();
    const std::size_t end = std::min(trials_, (block + 1) * ErrorDraws::block);
    std::size_t row = 0;
    std::vector<double> offset;
    for (std::size_t trial = block * ErrorDraws::block; trial < end; ++trial, ++row) {
      perturbation.apply(std::span(desk.errors).subspan(row * count, count),
                         derive_seed(seed_, static_cast<std::uint64_t>(trial)));
      for (std::size_t o = 0; o < outputs_.size(); ++o) keep(perturbation, trial, o, desk);
    }
  }

 private:
  void keep(const Perturbation& perturbation, std::size_t trial, std::size_t o, Desk& desk) {
    Offsets& output = outputs_[o];
    if (output.components.empty()) return;
    if (perturbation.failed(o)) {
      auto& first = desk.first_faults[o];
      if (trial < first.first) first = {trial, perturbation.fault(o).message};
      for (auto& component : output.components) component[trial] = nan;
      return;
    }
    desk.offset.resize(output.components.size());
    perturbation.offset(o, desk.offset);
    for (std::size_t c = 0; c < output.components.size(); ++c)
      output.components[c][trial] = desk.offset[c];
  }

  ErrorDraws draws_;
  std::size_t trials_;
  std::uint64_t seed_;
  std::vector<Offsets> outputs_;
};

/// Removes the trials without an output; all components have them at the same places.
void drop_failed(Offsets& output) {
  for (auto& component : output.components)
    std::erase_if(component, [](double x) { return std::isnan(x); });
}

double share_within(const std::vector<double>& offsets, double middle, double limit) {
  const auto inside = std::count_if(offsets.begin(), offsets.end(),
                                    [&](double x) { return std::abs(x - middle) <= limit; });
  return static_cast<double>(inside) / static_cast<double>(offsets.size());
}

/// Share of trials whose offset lies in the 95 % ellipsoid of a lineage's covariance.
double share_in_ellipsoid(const Offsets& output, const Lineage& lineage) {
  PrincipalAxes axes;
  axes.take(lineage);
  if (axes.rank() == 0) return nan;
  const double limit = axes.squared_radius_95();
  std::size_t inside = 0;
  const std::size_t trials = output.components.front().size();
  std::vector<double> offset(output.components.size());
  for (std::size_t t = 0; t < trials; ++t) {
    for (std::size_t c = 0; c < offset.size(); ++c) offset[c] = output.components[c][t];
    inside += axes.squared_distance(offset) <= limit ? 1 : 0;
  }
  return static_cast<double>(inside) / static_cast<double>(trials);
}

void take_moments(const Offsets& output, const Estimate& first_order, MonteCarloOutput& result) {
  const auto m = static_cast<Eigen::Index>(output.components.size());
  const auto trials = static_cast<double>(result.trials);
  Eigen::VectorXd offset(m);
  result.covariance.resize(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const auto& a = output.components[static_cast<std::size_t>(i)];
    offset[i] =
        Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size())).sum() /
        trials;
    for (Eigen::Index j = 0; j <= i; ++j) {
      const auto& b = output.components[static_cast<std::size_t>(j)];
      double sum = 0;
      for (std::size_t t = 0; t < a.size(); ++t) sum += (a[t] - offset[i]) * (b[t] - offset[j]);
      result.covariance(i, j) = result.covariance(j, i) = sum / std::max(1.0, trials - 1);
    }
  }
  const std::vector<double> mean = retract(*first_order.type, first_order.value,
                                           std::span(offset.data(), first_order.dimension()));
  result.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), m);
}

MonteCarloOutput summarise(Offsets& output, const Estimate& first_order, std::size_t trials) {
  MonteCarloOutput result;
  drop_failed(output);
  result.trials = output.components.empty() ? 0 : output.components.front().size();
  result.faults = trials - result.trials;
  result.fault = output.fault;
  if (result.trials == 0) return result;
  take_moments(output, first_order, result);
  result.joint_coverage = share_in_ellipsoid(output, first_order.lineage);
  for (std::size_t c = 0; c < output.components.size(); ++c) {
    const double deviation = first_order.lineage.standard_deviation(c);
    const double half_width = normal_coverage_factor_95 * deviation;
    result.coverage.push_back(deviation > 0 ? share_within(output.components[c], 0, half_width)
                                            : nan);
    const Interval offsets = shortest_interval(output.components[c], 0.95);
    result.agreeing_digits.push_back(agreeing_digits(0, half_width, deviation, offsets));
    result.interval.push_back(
        {first_order.value[c] + offsets.low, first_order.value[c] + offsets.high});
  }
  result.offsets = std::move(output.components);
  return result;
}

std::vector<MonteCarloOutput> summarise(Trials& run, const System& system, std::size_t trials) {
  std::vector<MonteCarloOutput> results;
  const std::vector<std::size_t>& nodes = system.plan().outputs;
  for (std::size_t o = 0; o < nodes.size(); ++o)
    results.push_back(summarise(run.outputs()[o], system.node(nodes[o]).output().estimate, trials));
  return results;
}

void check_trials(std::size_t trials) {
  if (trials < 1 || trials > most_trials)
    throw std::invalid_argument(
        fmt::format("a Monte Carlo run has 1 to {} trials, not {}", most_trials, trials));
}

/// Of several threads' first faults the very first.
void merge(const Trials::Desk& desk, std::vector<Offsets>& outputs) {
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const auto& [trial, fault] = desk.first_faults[o];
    if (trial >= outputs[o].first_fault) continue;
    outputs[o].first_fault = trial;
    outputs[o].fault = fault;
  }
}

}  // namespace

double MonteCarloOutput::coverage_around(std::size_t component, double bias,
                                         double deviation) const {
  return share_within(offsets[component], bias, normal_coverage_factor_95 * deviation);
}

std::vector<MonteCarloOutput> run_monte_carlo(const System& system,
                                              const std::vector<std::size_t>& cut,
                                              const MonteCarloOptions& options) {
  check_trials(options.trials);
  std::vector<std::size_t> sorted_cut = cut;
  std::sort(sorted_cut.begin(), sorted_cut.end());
  Trials run(system, options.trials, options.seed);
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const auto threads = static_cast<std::size_t>(
      std::min<std::uint64_t>(options.threads > 0 ? options.threads : cores, run.blocks()));
  std::atomic<std::size_t> next = 0;
  std::vector<Trials::Desk> desks(threads, run.desk());
  const auto work = [&](std::size_t thread) {
    Perturbation perturbation(system, system.plan().outputs, sorted_cut, Redo::simulation);
    for (std::size_t block = next++; block < run.blocks(); block = next++) {
      run.run(block, perturbation, desks[thread]);
      if (thread == 0 && options.progress)
        options.progress(static_cast<double>(block + 1) / static_cast<double>(run.blocks()));
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work, t);
    work(0);
  }
  for (const Trials::Desk& desk : desks) merge(desk, run.outputs());
  return summarise(run, system, options.trials);
}

std::vector<MonteCarloOutput> run_monte_carlo(const System& system, Perturbation& perturbation,
                                              std::size_t trials, std::uint64_t seed) {
  check_trials(trials);
  Trials run(system, trials, seed);
  Trials::Desk desk = run.desk();
  for (std::size_t block = 0; block < run.blocks(); ++block) run.run(block, perturbation, desk);
  merge(desk, run.outputs());
  return summarise(run, system, trials);
}

Interval shortest_interval(std::span<double> values, double probability) {
  const std::size_t n = values.size();
  if (n == 0) return {nan, nan};
  // The interval holds q values more than the one it starts at; both ends lie in the outer n - q.
  const auto q =
      std::min(n - 1, static_cast<std::size_t>(std::ceil(probability * static_cast<double>(n))));
  const std::size_t outer = n - q;
  const auto begin = values.begin();
  const auto at = [&](std::size_t i) { return begin + static_cast<std::ptrdiff_t>(i); };
  // Sorting these alone costs a tenth of sorting all.
  if (q > outer) {
    std::nth_element(begin, at(outer), values.end());
    std::nth_element(at(outer), at(q), values.end());
    std::sort(begin, at(outer));
    std::sort(at(q), values.end());
  } else {
    std::sort(begin, values.end());
  }
  Interval best{values[0], values[q]};
  for (std::size_t i = 1; i < outer; ++i)
    if (values[i + q] - values[i] < best.high - best.low) best = {values[i], values[i + q]};
  return best;
}

int agreeing_digits(double value, double half_width, double standard_uncertainty,
                    const Interval& other) {
  const double worst =
      std::max(std::abs(value - half_width - other.low), std::abs(value + half_width - other.high));
  if (standard_uncertainty <= 0) return worst == 0 ? 2 : 0;
  // The place of the uncertainty's first digit, after rounding to it.
  for (const int digits : {2, 1}) {
    int place = static_cast<int>(std::floor(std::log10(standard_uncertainty))) - digits + 1;
    if (std::round(standard_uncertainty / std::pow(10.0, place)) >= std::pow(10.0, digits)) ++place;
    if (worst <= 0.5 * std::pow(10.0, place)) return digits;
  }
  return 0;
}

}  // namespace ilss
