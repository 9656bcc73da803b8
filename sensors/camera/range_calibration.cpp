#include "sensors/camera/range_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ilss {
namespace {

const char* const undetermined =
    "the calibration pairs do not determine the hyperbola row = horizon - scale / range with a "
    "scale above 0";

}  // namespace

void RangeCalibration::Pair::declare(OptionVisitor& visit) {
  visit("range", range, "measured along the optical axis",
        {.unit = "m", .required = true, .minimum = 1e-6});
  visit("row", row, "where the line's centre shows, in pixels", {.required = true});
}

void RangeCalibration::Options::declare(OptionVisitor& visit) {
  visit("pairs", pairs, "ranges with the rows seen there", {.required = true});
  visit("row_std", row_std, "error of the pairs' rows, in pixels; from the residuals if not given",
        {.minimum = 0});
  const auto different = [&] {
    return std::any_of(pairs.begin(), pairs.end(),
                       [&](const Pair& pair) { return pair.range != pairs.front().range; });
  };
  visit.require(pairs.size() >= (row_std ? 2u : 3u) && different(),
                "a calibration needs pairs at two ranges or more, and three pairs or more where "
                "row_std is not given");
}

Interface RangeCalibration::interface() {
  return {{{"row", &descriptor<ImageRow>(), {}, false}}, &descriptor<WallRange>(), {}, 0};
}

std::optional<RowRangeFit> RangeCalibration::fit(const Options& options) {
  const std::size_t least = options.row_std ? 2 : 3;
  if (options.pairs.size() < least) return std::nullopt;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (const Pair& pair : options.pairs) {
    const Eigen::Vector2d basis(1, -1 / pair.range);
    normal += basis * basis.transpose();
    moment += basis * pair.row;
  }
  const Eigen::LDLT<Eigen::Matrix2d> factor(normal);
  constexpr double least_condition = 1e-12;
  if (!normal.allFinite() || !(factor.rcond() > least_condition)) return std::nullopt;
  const Eigen::Vector2d solution = factor.solve(moment);

  RowRangeFit result;
  result.horizon = solution[0];
  result.scale = solution[1];
  if (!(result.scale > 0)) return std::nullopt;
  double squares = 0;
  for (const Pair& pair : options.pairs)
    squares += std::pow(pair.row - (result.horizon - result.scale / pair.range), 2);
  result.row_std = options.row_std.value_or(
      std::sqrt(squares / static_cast<double>(std::max<std::size_t>(options.pairs.size(), 3) - 2)));
  result.covariance = result.row_std * result.row_std * factor.solve(Eigen::Matrix2d::Identity());
  return result;
}

void RangeCalibration::add_calibration_error(const Evaluation& evaluation, double range,
                                             Estimate& estimate) const {
  // range = scale / (horizon - row): by the horizon -range² / scale, by the scale range / scale.
  const Eigen::RowVector2d by_fit(-range * range / fit_->scale, range / fit_->scale);
  const Eigen::Matrix2d factor = fit_->covariance.llt().matrixL();
  const Eigen::RowVector2d columns = by_fit * factor;
  for (std::uint32_t k = 0; k < 2; ++k)
    estimate.lineage.add({evaluation.owner, k, persistent_tick}, 0, columns[k]);
}

Outcome<> RangeCalibration::evaluate(const Evaluation& evaluation, Output& output) {
  if (!fit_) return Fault{FaultKind::degenerate, undetermined};
  const Estimate& row = evaluation.input(0);
  const double height = fit_->horizon - row.value[index_of<ImageRow>("row")];
  if (!(height > 0))
    return Fault{FaultKind::out_of_range,
                 "the row lies on or below the calibrated horizon: no range shows there"};
  const double range = fit_->scale / height;
  output.estimate.value.assign(1, range);
  const double by_row = range / height;
  const LineageTerm term{&by_row, &row.lineage};
  compose({&term, 1}, 1, output.estimate.lineage);
  add_calibration_error(evaluation, range, output.estimate);
  return {};
}

Outcome<> RangeCalibration::expect(const Evaluation& evaluation, const Output* operating_point,
                                   Output& output) {
  if (operating_point == nullptr) return evaluate(evaluation, output);
  if (!fit_) return Fault{FaultKind::degenerate, undetermined};
  const double range = operating_point->estimate.value[index_of<WallRange>("range")];
  output.estimate.value.assign(1, range);
  output.estimate.lineage.reset(1);
  output.estimate.lineage.add(evaluation.fresh(0), 0, range * range / fit_->scale * fit_->row_std);
  add_calibration_error(evaluation, range, output.estimate);
  return {};
}

}  // namespace ilss
