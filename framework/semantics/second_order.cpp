#include "framework/semantics/second_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ilss {

void SecondOrderSearch::run(const System& system, Perturbation& perturbation,
                            const ErrorDraws& draws, std::span<SecondOrder> outputs) {
  perturbation_ = &perturbation;
  outputs_ = outputs;
  begin(system);
  move_each();
  move_pairs();
  move_together(draws);
}

void SecondOrderSearch::begin(const System& system) {
  errors_.assign(perturbation_->sources().size(), 0.0);
  first_.clear();
  std::size_t directions = 0;
  for (std::size_t t = 0; t < outputs_.size(); ++t) {
    first_.push_back(directions);
    SecondOrder& output = outputs_[t];
    output.meets_fault = output.wanted && perturbation_->failed(t);
    output.changes_label = false;
    output.sources.clear();
    output.moments.clear();
    if (!output.wanted) continue;
    const Lineage& lineage = system.node(perturbation_->target_node(t)).output().estimate.lineage;
    output.axes.take(lineage);
    output.moments.resize(lineage.dimension() + (lineage.dimension() > 1 ? output.axes.rank() : 0));
    directions += output.moments.size();
  }
  for (Offsets* offsets : {&a_, &b_, &c_, &d_}) offsets->resize(directions);
}

/// What the errors as they stand do to each output, or to each that was redone; noted where they
/// leave none.
void SecondOrderSearch::measure(Offsets& offsets, Take take) {
  perturbation_->apply(errors_);
  for (std::size_t t = 0; t < outputs_.size(); ++t) {
    SecondOrder& output = outputs_[t];
    if (!output.wanted || (take == Take::changed && !perturbation_->changed(t))) continue;
    const std::span<double> along = std::span(offsets).subspan(first_[t], output.moments.size());
    if (perturbation_->failed(t)) {
      output.meets_fault = true;
      std::fill(along.begin(), along.end(), 0.0);
      continue;
    }
    output.changes_label |= perturbation_->changed_label(t);
    offset_.resize(perturbation_->value(t).dimension());
    perturbation_->offset(t, offset_);
    std::copy(offset_.begin(), offset_.end(), along.begin());
    for (std::size_t r = offset_.size(); r < along.size(); ++r) {
      const std::span<const double> axis = output.axes.axis(r - offset_.size());
      along[r] = std::inner_product(axis.begin(), axis.end(), offset_.begin(), 0.0);
    }
  }
}

/// Calls `gather(moments, place in Offsets)` for each direction of an output.
template <typename Gather>
void SecondOrderSearch::for_each_direction(std::size_t target, const Gather& gather) {
  std::size_t at = first_[target];
  for (Moments& moments : outputs_[target].moments) gather(moments, at++);
}

/// One source at a time, to both sides.
void SecondOrderSearch::move_each() {
  const double step = std::sqrt(3.0);
  for (std::size_t k = 0; k < errors_.size(); ++k) {
    errors_[k] = step;
    measure(a_);
    errors_[k] = -step;
    measure(b_);
    for (std::size_t t = 0; t < outputs_.size(); ++t) {
      if (!outputs_[t].wanted || !perturbation_->changed(t)) continue;
      outputs_[t].sources.push_back(k);
      for_each_direction(t, [&](Moments& m, std::size_t i) {
        const double second = (a_[i] + b_[i]) / (step * step);
        const double secant = (a_[i] - b_[i]) / (2 * step);
        m.curvature += second;
        m.squared_curvature += second * second;
        m.secant_variance += secant * secant;
      });
    }
    errors_[k] = 0;
    perturbation_->apply(errors_);  // so that what changes next is what follows from the next one
  }
}

/// Two sources at a time, by ±1 standard deviation: their mixed second derivatives.
void SecondOrderSearch::move_pairs() {
  const auto is_paired = [](const SecondOrder& output) {
    return output.wanted && output.sources.size() <= most_paired_sources;
  };
  pairs_.clear();
  for (const SecondOrder& output : outputs_) {
    if (!is_paired(output)) continue;
    for (std::size_t i = 0; i < output.sources.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) pairs_.emplace_back(output.sources[i], output.sources[j]);
  }
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  const auto depends_on = [](const SecondOrder& output, std::size_t source) {
    return std::binary_search(output.sources.begin(), output.sources.end(), source);
  };
  for (const auto& [i, j] : pairs_) {
    const auto measure_at = [&, i = i, j = j](double a, double b, Offsets& offsets) {
      errors_[i] = a;
      errors_[j] = b;
      measure(offsets);
    };
    measure_at(1, 1, a_);
    measure_at(-1, -1, b_);
    measure_at(1, -1, c_);
    measure_at(-1, 1, d_);
    for (std::size_t t = 0; t < outputs_.size(); ++t) {
      if (!is_paired(outputs_[t]) || !depends_on(outputs_[t], i) || !depends_on(outputs_[t], j))
        continue;
      for_each_direction(t, [&](Moments& m, std::size_t at) {
        const double mixed = (a_[at] + b_[at] - c_[at] - d_[at]) / 4;
        m.mixed_variance += mixed * mixed;
      });
    }
    errors_[i] = errors_[j] = 0;
  }
}

/// All sources at once by ±1 standard deviation, signs drawn: with second derivatives H, the mean
/// of both ways is tr(H) / 2 + sum of s_i s_j H_ij over i < j, so its scatter is the mixed part.
void SecondOrderSearch::move_together(const ErrorDraws& draws) {
  constexpr int rounds = 48;  // at most as many as a seed has bits
  const auto has_many = [](const SecondOrder& output) {
    return output.wanted && output.sources.size() > most_paired_sources;
  };
  if (std::none_of(outputs_.begin(), outputs_.end(), has_many)) return;
  signs_.clear();
  for (const Source& source : perturbation_->sources())
    signs_.push_back(mix(draws.seed_of(source)));
  for (int round = 0; round < rounds; ++round) {
    const auto measure_at = [&](double factor, Offsets& offsets) {
      for (std::size_t k = 0; k < errors_.size(); ++k)
        errors_[k] = (signs_[k] >> round & 1) != 0 ? factor : -factor;
      measure(offsets, Take::all);
    };
    measure_at(1, a_);
    measure_at(-1, b_);
    for (std::size_t t = 0; t < outputs_.size(); ++t) {
      if (!has_many(outputs_[t])) continue;
      for_each_direction(t, [&](Moments& m, std::size_t i) {
        const double mixed = (a_[i] + b_[i]) / 2 - m.bias();
        m.mixed_variance += mixed * mixed / rounds;
      });
    }
  }
}

}  // namespace ilss
