// Estimates of one thing whose correlation is not known, made into one that is never overconfident.
#pragma once

#include <array>

#include "framework/module/module_type.h"
#include "sensors/fusion/joint_deviations.h"

namespace ilss {

/// Covariance intersection (Julier & Uhlmann 1997), split (2001) into what is known to be shared
/// and what is not. With simplex weights w_i that maximise det(sum w_i P_i⁻¹):
///   P⁻¹ = sum w_i P_i⁻¹,  W_i = w_i P P_i⁻¹ (sum W_i = I),  x = sum W_i z_i.
/// Persistent columns of the lineage are mapped by the W_i, so that what is systematic stays so.
/// Random errors of covariance R_i become columns of their own under the bound
///   R = sum (1/w_i) W_i R_i W_iᵀ,
/// which holds for any simplex weights and any correlation: for every v, Cauchy-Schwarz gives
///   Var(sum vᵀW_i e_i) <= (sum sd_i)² = (sum sqrt(w_i) sd_i/sqrt(w_i))² <= sum sd_i²/w_i = vᵀR v.
/// So neither the search for weights nor rounding in them can make the result overconfident.
///
/// Directions in which an estimate claims to be exact count as a millionth of the largest standard
/// deviation of their unit when weights and gains are found; the bound is of the errors as stated.
/// The result says `correlation_unknown`, and which of the inputs is to blame can no longer be
/// told: its budget blames this module. Fault `degenerate`: exact inputs that differ.
Outcome<> intersect_covariances(const Evaluation& evaluation, Estimate& estimate);

/// Function module: `intersect_covariances` of two or more estimates of any payload.
class CovarianceIntersection final : public Module {
 public:
  static constexpr std::string_view name = "covariance_intersection";
  static constexpr std::string_view description =
      "one estimate of several whose correlation is not known, never overconfident";
  static constexpr std::string_view reference = "Julier & Uhlmann 1997; split form 2001";
  static constexpr ModuleKind kind = ModuleKind::function;
  static constexpr std::array faults = {FaultKind::degenerate};
  static constexpr bool severs = true;
  static constexpr bool weighs_errors = true;

  static Interface interface();
  static void resolve(const Connections& connections, Settings& settings, Interface& interface);

  Outcome<> evaluate(const Evaluation& evaluation, Output& output) override;
};

}  // namespace ilss
