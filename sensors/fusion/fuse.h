// The best estimate of one thing out of several, with all that is known of their correlation.
#pragma once

#include <array>

#include "framework/module/module_type.h"

namespace ilss {

/// Function module: the best linear unbiased estimate from the joint covariance of two or more
/// estimates z_i of any payload (Aitken 1936; Bar-Shalom & Campo 1986 for two). With z the inputs'
/// mean and y their deviations from it, Y the factor of Cov(y) = Y Yᵀ and G that of z,
///   x = z - G Y⁺ y = sum W_i z_i,  W_i = I/n - (G Y⁺)_i,
/// and the lineage is the inputs' mapped by the W_i. Nothing is assumed of the inputs' rank: they
/// may be exact, share errors in part or in full, or have fewer unknowns than components. Angles
/// are taken on the circle, rotations in the tangent at the result; the order of inputs does not
/// matter. Where only first order's tilt of
/// two constraints would make the result exact, they count as one (JointDeviations).
///
/// Where the correlation of inputs is not known, by the plan or by what an input says, it is
/// `covariance_intersection` that makes the output. Fault `degenerate`: the inputs differ where
/// they claim not to.
class Fuse final : public Module {
 public:
  static constexpr std::string_view name = "fuse";
  static constexpr std::string_view description =
      "the best estimate from several, whatever errors they share";
  static constexpr std::string_view reference =
      "Aitken 1936; Bar-Shalom & Campo 1986; Julier & Uhlmann 1997 where correlation is unknown";
  static constexpr ModuleKind kind = ModuleKind::function;
  static constexpr std::array faults = {FaultKind::degenerate};
  static constexpr bool weighs_errors = true;

  static Interface interface();
  static void resolve(const Connections& connections, Settings& settings, Interface& interface);

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
};

/// Whether lineages do not tell how a module's inputs are correlated.
bool inputs_of_unknown_correlation(const Evaluation& evaluation);

}  // namespace ilss
