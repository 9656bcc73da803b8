// Do several estimates of one thing differ by no more than they say?
#pragma once

#include "framework/module/module_type.h"

namespace ilss {

/// How likely the differences of several estimates are if all of them are honest.
template <typename T>
struct Consistency {
  T nis, degrees_of_freedom, probability;

  static constexpr std::string_view name = "consistency";
  static constexpr std::string_view documentation =
      "how likely the differences of several estimates are";
  static constexpr auto fields =
      Fields{{"nis", "1", "normalised innovation squared of all inputs' differences"},
             {"degrees_of_freedom", "1", "its mean where all inputs are honest"},
             {"probability", "1", "chance of a nis at least this large where they are"}};
};

/// Function module: the normalised innovation squared yᵀ Cov(y)⁺ y of the deviations y of two or
/// more estimates of any payload from their mean, errors that they share accounted for (Bar-Shalom,
/// Li, Kirubarajan 2001, sec. 5.4); degrees of freedom are the rank of Cov(y), and `probability`
/// is what a chi-square variable gives. It is 1 where there is nothing to compare (rank 0), and 0
/// where inputs differ in what they claim to be exact. The output is a statistic and has no error.
///
/// Where the inputs' correlation is not known, Cov(y) is a bound that holds for any correlation
/// of their random errors (`bounded_joint_estimates`): then nis is a lower bound, and `probability`
/// an upper one, so that a monitor which minds small probabilities raises no alarm that it should
/// not, but may miss some.
class ConsistencyModule final : public Module {
 public:
  static constexpr std::string_view name = "consistency";
  static constexpr std::string_view description =
      "how likely the differences of several estimates are, if they are honest";
  static constexpr std::string_view reference = "Bar-Shalom, Li & Kirubarajan 2001, sec. 5.4";
  static constexpr ModuleKind kind = ModuleKind::function;
  static constexpr bool weighs_errors = true;
  static constexpr bool states_no_error = true;

  static Interface interface();
  static void resolve(const Connections& connections, Settings& settings, Interface& interface);

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
};

}  // namespace ilss
