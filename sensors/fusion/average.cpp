#include "sensors/fusion/average.h"

#include <algorithm>
#include <array>

#include "sensors/fusion/fuse.h"
#include "sensors/fusion/fusion_inputs.h"

namespace ilss {
namespace {

/// Folders of the system's own folding are the nodes' indices, from 0 up; these start halfway to
/// the limit of 2^24, so that an average's blocks never share a name with what is folded elsewhere.
constexpr std::uint32_t first_folder = 1u << 23;

/// What is averaged, the weight that it has, and how the mean moves with its error (m x m,
/// column-major): by the weight where errors at one value are errors at any.
struct Part {
  LineageTerm term;
  double weight;
};

/// The lineage of a mean whose parts' random errors go together in an unknown way. Weights add up
/// to 1, and then Cov(sum w_i e_i) <= sum w_i Cov(e_i) whatever the correlation (Jensen).
void bounded_mean(std::span<const Part> parts, Source first, Lineage& out) {
  const std::size_t dimension = parts.front().term.lineage->dimension();
  const auto m = static_cast<Eigen::Index>(dimension);
  Eigen::MatrixXd random = Eigen::MatrixXd::Zero(m, m);
  out.reset(dimension);
  for (const auto& [term, weight] : parts) {
    const Eigen::Map<const Eigen::MatrixXd> jacobian(term.jacobian, m, m);
    const Lineage& lineage = *term.lineage;
    for (std::size_t k = 0; k < lineage.size(); ++k) {
      const Eigen::VectorXd weighted =
          jacobian * lineage.factor().col(static_cast<Eigen::Index>(k));
      if (lineage.sources()[k].persistent())
        out.add(lineage.sources()[k], std::span<const double>(weighted.data(), dimension));
      else
        random += weighted * weighted.transpose() / weight;
    }
  }
  out.add_noise(first, random);
}

}  // namespace

void Average::Options::declare(OptionVisitor& visit) {
  visit("window", window, "how many of the latest values count; 0: all since the start",
        {.minimum = 0, .maximum = 1e6});
}

Interface Average::interface() {
  return {{{"estimate", &any_payload(), {}, false}}, &any_payload(), {}, 0};
}

void Average::resolve(const Connections& connections, Settings&, Interface& interface) {
  resolve_fusion(connections, 1, name, interface);
}

void Average::reset() {
  count_ = 0;
  oldest_ = 0;
  readings_.clear();
}

void Average::start(const Estimate& reading) {
  mean_ = reading;
  count_ = 1;
}

void Average::move_towards(const Estimate& reading) {
  const PayloadDescriptor& type = *reading.type;
  const std::size_t m = reading.dimension();
  const double share = 1.0 / static_cast<double>(count_);
  move_.resize(m);
  difference(type, reading.value, mean_.value, move_);
  jacobians_.assign(2 * m * m, 0.0);
  for (std::size_t c = 0; c < m; ++c) {
    jacobians_[c * m + c] = 1 - share;
    jacobians_[m * m + c * m + c] = share;
  }
  if (!is_flat(type)) take_tangents(type, share);
  for (double& component : move_) component *= share;
  retract(type, mean_.value, move_, mean_.value);
}

void Average::take_tangents(const PayloadDescriptor& type, double share) {
  const auto m = static_cast<Eigen::Index>(type.dimension());
  const Eigen::VectorXd apart = Eigen::Map<const Eigen::VectorXd>(move_.data(), m);
  const Eigen::VectorXd move = share * apart;
  const std::span<const double> d(apart.data(), move_.size());
  const std::span<const double> e(move.data(), move_.size());
  const Eigen::MatrixXd by_move = share * retract_by_error(type, e);
  Eigen::Map<Eigen::MatrixXd>(jacobians_.data(), m, m) =
      retract_by_value(type, e) + by_move * difference_by_second(type, d);
  Eigen::Map<Eigen::MatrixXd>(jacobians_.data() + m * m, m, m) =
      by_move * difference_by_first(type, d);
}

void Average::fold_past(const Evaluation& evaluation) {
  // What the reading holds, too, such as the error of a value that is held over ticks, keeps its
  // name, so that it does not average out.
  const std::span<const Source> present = evaluation.input(0).lineage.sources();
  const auto is_past = [&present](const Source& source) {
    return !source.persistent() && !std::binary_search(present.begin(), present.end(), source);
  };
  mean_.lineage.fold(is_past, first_folder + evaluation.owner);
}

void Average::add_to_mean(const Evaluation& evaluation, bool ticks_are_correlated) {
  const Estimate& reading = evaluation.input(0);
  if (count_ == 0) return start(reading);
  ++count_;
  move_towards(reading);
  const std::size_t m = reading.dimension();
  const double share = 1.0 / static_cast<double>(count_);
  const std::array<LineageTerm, 2> terms = {
      {{jacobians_.data(), &mean_.lineage}, {jacobians_.data() + m * m, &reading.lineage}}};
  if (ticks_are_correlated) {
    const std::array<Part, 2> parts = {{{terms[0], 1 - share}, {terms[1], share}}};
    bounded_mean(parts, evaluation.fresh(0), next_);
  } else {
    fold_past(evaluation);
    compose(terms, m, next_);
  }
  std::swap(mean_.lineage, next_);
}

void Average::add_to_window(const Evaluation& evaluation, bool ticks_are_correlated) {
  const Estimate& reading = evaluation.input(0);
  if (readings_.size() < window_) {
    readings_.push_back(reading);
  } else {
    readings_[oldest_] = reading;
    oldest_ = (oldest_ + 1) % window_;
  }
  const double share = 1.0 / static_cast<double>(readings_.size());
  const std::vector<double> weights(readings_.size(), share);
  mean_ = linear_combination(readings_, weights);
  if (!ticks_are_correlated) return;
  const auto m = static_cast<Eigen::Index>(reading.dimension());
  const auto count = static_cast<Eigen::Index>(readings_.size());
  Eigen::MatrixXd gains = share * Eigen::MatrixXd::Identity(m, m).replicate(1, count);
  Eigen::MatrixXd differences(m, count);
  std::vector<Part> parts;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Estimate& kept = readings_[static_cast<std::size_t>(i)];
    differences.col(i) = difference(kept, mean_.value);
    parts.push_back({{gains.data() + i * m * m, &kept.lineage}, share});
  }
  transport_gains(*reading.type, differences, gains);
  bounded_mean(parts, evaluation.fresh(0), mean_.lineage);
}

Outcome<> Average::evaluate(const Evaluation& evaluation, Output& output) {
  const bool ticks_are_correlated = inputs_of_unknown_correlation(evaluation);
  if (window_ > 0)
    add_to_window(evaluation, ticks_are_correlated);
  else
    add_to_mean(evaluation, ticks_are_correlated);
  output.estimate.value = mean_.value;
  output.estimate.lineage = mean_.lineage;
  output.estimate.labels = evaluation.input(0).labels;
  return {};
}

Outcome<> Average::expect(const Evaluation& evaluation, const Output* operating_point,
                          Output& output) {
  if (operating_point != nullptr) return Module::expect(evaluation, operating_point, output);
  const Estimate& reading = evaluation.input(0);
  output.estimate.value = reading.value;
  output.estimate.lineage = reading.lineage;
  output.estimate.labels = reading.labels;
  return {};
}

}  // namespace ilss
