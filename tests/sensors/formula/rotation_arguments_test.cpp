// Formulas over rotations in space: components are rotation vectors, errors are local.
#include <gtest/gtest.h>

#include "framework/estimate/random.h"
#include "framework/estimate/rotation.h"
#include "sensors/formula/formula_interface.h"
#include "tests/orientation.h"

namespace ilss {
namespace {

const PayloadDescriptor& orientation() { return descriptor<test::Orientation>(); }

Estimate drawn_orientation(RandomBits& random) {
  Estimate estimate(orientation());
  for (double& component : estimate.value) component = draw_uniform(random, -1.8, 1.8);
  normalize(orientation(), estimate.value);
  for (std::uint32_t c = 0; c < 3; ++c) estimate.lineage.add({0, c, 0}, c, 1);
  return estimate;
}

TEST(RotationArguments, MoveByTheirLocalErrors) {
  // The components themselves: log(exp(r) exp(e)) = r + J_r⁻¹(r) e.
  FormulaArguments arguments;
  arguments.list = {{"r.rx", "rad"}, {"r.ry", "rad"}, {"r.rz", "rad"}};
  arguments.first = {0, 3, 3};
  ArgumentReader reader(arguments);
  const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
  RandomBits random(1);
  for (int i = 0; i < 100; ++i) {
    Output input;
    input.estimate = drawn_orientation(random);
    const Output* const inputs[] = {&input};
    const Estimate none(no_parameters());
    const Evaluation evaluation{.parameters = none, .inputs = inputs};
    Lineage lineage;
    reader.propagate(evaluation, {same.data(), 9}, 3, lineage);
    const auto& r = input.estimate.value;
    EXPECT_LT((lineage.factor() - inverse_right_jacobian({r[0], r[1], r[2]})).norm(), 1e-13);
  }
}

TEST(RotationResults, HaveLocalErrors) {
  RandomBits random(2);
  for (int i = 0; i < 100; ++i) {
    Estimate estimate = drawn_orientation(random);
    const RotationVector<double> r = {estimate.value[0], estimate.value[1], estimate.value[2]};
    settle_result(estimate);
    EXPECT_LT((estimate.lineage.factor() - right_jacobian(r)).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace ilss
