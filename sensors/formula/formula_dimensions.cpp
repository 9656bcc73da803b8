#include "sensors/formula/formula_dimensions.h"

#include <fmt/format.h>

namespace ilss {
namespace {

/// A node's dimension, as far as it is known.
struct Known {
  std::optional<Dimension> dimension = {};
  bool fits_any = false;  ///< the number 0, or unknown: nothing more is said of it
};

class DimensionCheck {
 public:
  DimensionCheck(const Tape& tape, const std::vector<Dimension>& arguments) : tape_(tape) {
    for (const Dimension& dimension : arguments) known_.push_back({dimension, false});
    known_.resize(tape.nodes().size(), unknown);
  }

  std::vector<std::string> check(const Tape::Formula& formula,
                                 const std::optional<Dimension>& result) {
    for (Tape::Index i = formula.first; i < formula.end; ++i) known_[i] = dimension_of(i);
    const Known& known = known_[formula.result];
    if (result && !known.fits_any && *known.dimension != *result) {
      const bool turns = *known.dimension / *result == Dimension::angle() ||
                         *result / *known.dimension == Dimension::angle();
      problems_.push_back(fmt::format("gives {}, but its unit says {}{}", known.dimension->name(),
                                      result->name(),
                                      turns ? "; write '* rad' or '/ rad' where an angle stands "
                                              "for a number"
                                            : ""));
    }
    return std::move(problems_);
  }

 private:
  static inline const Known unknown{std::nullopt, true};
  static Known a(const Dimension& dimension) { return {dimension, false}; }

  Known complain(std::string problem) {
    problems_.push_back(std::move(problem));
    return unknown;
  }

  Known dimension_of(Tape::Index index) {
    const Tape::Node& node = tape_.nodes()[index];
    const Known& left = known_[node.left];
    const Known& right = known_[node.right];
    switch (node.operation) {
      case Operation::argument:
        return known_[index];
      case Operation::constant:
        return {Dimension(), node.constant == 0};
      case Operation::radian:
        return a(Dimension::angle());
      case Operation::add:
        return either(left, right, "adds {} and {}");
      case Operation::subtract:
        return either(left, right, "subtracts {1} from {0}");
      case Operation::minimum:
      case Operation::maximum:
        return either(left, right, "compares {} with {}");
      case Operation::hypot:
        return either(left, right, "takes the hypotenuse of {} and {}");
      case Operation::atan2:
        either(left, right, "takes the direction of {} and {}");
        return a(Dimension::angle());
      case Operation::multiply:
        return left.dimension && right.dimension ? a(*left.dimension * *right.dimension) : unknown;
      case Operation::divide:
        return left.dimension && right.dimension ? a(*left.dimension / *right.dimension) : unknown;
      case Operation::power:
        return power(node, left, right);
      case Operation::negate:
      case Operation::abs:
        return left;
      case Operation::sqrt:
        return left.dimension ? a(left.dimension->power(0.5)) : unknown;
      case Operation::sin:
      case Operation::cos:
      case Operation::tan:
        return of_angle(node, left);
      case Operation::asin:
      case Operation::acos:
      case Operation::atan:
        return of_number(node, left, Dimension::angle());
      case Operation::exp:
      case Operation::log:
      case Operation::log10:
      case Operation::sinh:
      case Operation::cosh:
      case Operation::tanh:
        return of_number(node, left, Dimension());
    }
    return unknown;
  }

  /// The dimension of both, which must be one.
  Known either(const Known& left, const Known& right, std::string_view problem) {
    if (!left.fits_any && !right.fits_any && *left.dimension != *right.dimension)
      return complain(
          fmt::format(fmt::runtime(problem), left.dimension->name(), right.dimension->name()));
    return left.fits_any ? right : left;
  }

  Known power(const Tape::Node& node, const Known& base, const Known& exponent) {
    if (!exponent.fits_any && !exponent.dimension->is_pure_number())
      return complain(fmt::format("has {} as an exponent", exponent.dimension->name()));
    if (!base.dimension || base.dimension->is_pure_number()) return base;
    if (tape_.nodes()[node.right].varies)
      return complain(fmt::format("raises {} to a power that varies; the exponent must be a number",
                                  base.dimension->name()));
    return a(base.dimension->power(tape_.nodes()[node.right].constant));
  }

  Known of_angle(const Tape::Node& node, const Known& operand) {
    if (operand.fits_any || *operand.dimension == Dimension::angle()) return a(Dimension());
    complain(
        fmt::format("takes {} of {}, not of an angle (rad){}", operation_name(node.operation),
                    operand.dimension->name(),
                    operand.dimension->is_pure_number() ? "; write '* rad' to make it one" : ""));
    return a(Dimension());
  }

  Known of_number(const Tape::Node& node, const Known& operand, const Dimension& result) {
    if (operand.fits_any || operand.dimension->is_pure_number()) return a(result);
    complain(fmt::format(
        "takes {} of {}, not of a pure number{}", operation_name(node.operation),
        operand.dimension->name(),
        *operand.dimension == Dimension::angle() ? "; write '/ rad' to make it one" : ""));
    return a(result);
  }

  const Tape& tape_;
  std::vector<Known> known_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_dimensions(const Tape& tape, std::size_t formula,
                                          const std::vector<Dimension>& arguments,
                                          const std::optional<Dimension>& result) {
  return DimensionCheck(tape, arguments).check(tape.formulas()[formula], result);
}

}  // namespace ilss
