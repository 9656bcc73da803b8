// The mean over time of one estimate's values.
#pragma once

#include <vector>

#include "framework/module/module_type.h"

namespace ilss {

/// Estimator: the mean of an estimate of any payload over all ticks since the start, or over the
/// last `window` ones. Random errors average out, systematic ones do not; a value that is held over
/// ticks counts with its error as one. Angles and rotations are averaged near the mean so far.
///
/// Of all ticks, mean_n = mean_{n-1} ⊕ (x_n ⊖ mean_{n-1}) / n, with the lineage composed alike.
/// What is left of earlier ticks' random errors is folded, each owner apart, into blocks whose
/// correlation with another module's blocks of the same origin is not known: `check` says where
/// such meet. Memory and time a tick do not grow. A window keeps its estimates' lineages whole, and
/// costs as much as it is long.
///
/// Where the input's own ticks are correlated in a way that is not known (an average of averages),
/// random errors are taken not to average out at all: Var(mean) <= mean of the variances, whatever
/// the correlation. The output then says `correlation_unknown`, and blames this module for them.
class Average final : public Module {
 public:
  static constexpr std::string_view name = "average";
  static constexpr std::string_view description =
      "mean over time, in which random errors average out and systematic ones do not";
  static constexpr ModuleKind kind = ModuleKind::estimator;
  static constexpr bool remembers = true;

  struct Options {
    std::int64_t window = 0;
    void declare(OptionVisitor& visit);
  };

  static Interface interface();
  static void resolve(const Connections& connections, Settings& settings, Interface& interface);

  explicit Average(const Options& options) : window_(static_cast<std::size_t>(options.window)) {}

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
  /// Of one reading: the reading itself.
  Outcome<> expect(const Evaluation& evaluation, const Output* operating_point,
                   Output& output) override;
  void reset() override;

 private:
  void start(const Estimate& reading);
  void add_to_mean(const Evaluation& evaluation, bool ticks_are_correlated);
  void add_to_window(const Evaluation& evaluation, bool ticks_are_correlated);
  void move_towards(const Estimate& reading);
  void take_tangents(const PayloadDescriptor& type, double share);
  void fold_past(const Evaluation& evaluation);

  std::size_t window_;     ///< 0: all ticks
  std::size_t count_ = 0;  ///< of readings in the mean
  Estimate mean_;
  Lineage next_;                    ///< the mean's lineage in the making
  std::vector<double> move_;        ///< from the mean so far to the reading
  std::vector<double> jacobians_;   ///< by errors of the mean so far and of the reading
  std::vector<Estimate> readings_;  ///< of the window, the oldest overwritten
  std::size_t oldest_ = 0;
};

}  // namespace ilss
