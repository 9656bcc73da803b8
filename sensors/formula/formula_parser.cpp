// muParser does the grammar. It computes with doubles; here every double is the number of a node on
// the tape, and what it calls to compute appends a node instead.
#include "sensors/formula/formula_parser.h"

#include <fmt/format.h>
#include <muParserBase.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <numbers>

#include "framework/estimate/units.h"
#include "framework/module/document.h"

namespace ilss {
namespace {

constexpr std::size_t longest_formula = 10'000;
constexpr const char* letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
constexpr const char* digits = "0123456789";

/// The tape that the parser at work in this thread appends to: muParser's operators take no
/// context.
thread_local Tape* building = nullptr;

double number_of(Tape::Index node) { return node; }
Tape::Index node_of(double number) { return static_cast<Tape::Index>(number); }

template <Operation operation>
double append_unary(double operand) {
  return number_of(building->add(operation, node_of(operand)));
}
template <Operation operation>
double append_binary(double left, double right) {
  return number_of(building->add(operation, node_of(left), node_of(right)));
}
/// Of two operands or more, joined one after another.
template <Operation operation>
double append_chain(const double* operands, int count) {
  double result = operands[0];
  for (int i = 1; i < count; ++i) result = append_binary<operation>(result, operands[i]);
  return result;
}
double unary_plus(double operand) { return operand; }

/// The end of the number that begins at `begin`, or `begin`.
const char* read_number(const char* begin, const char* end, double& value) {
  if (begin == end || !(std::isdigit(static_cast<unsigned char>(*begin)) || *begin == '.'))
    return begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  return error == std::errc{} ? stop : begin;
}

int identify_number(const char* text, int* position, double* number) {
  double value = 0;
  const std::string_view rest(text);
  const char* stop = read_number(rest.data(), rest.data() + rest.size(), value);
  if (stop == rest.data()) return 0;
  *position += static_cast<int>(stop - rest.data());
  *number = number_of(building->add_constant(value));
  return 1;
}

class TapeParser final : public mu::ParserBase {
 public:
  TapeParser() {
    EnableOptimizer(false);
    EnableBuiltInOprt(false);
    AddValIdent(identify_number);
    InitCharSets();
    InitOprt();
    InitFun();
  }

 private:
  void InitCharSets() override {
    DefineNameChars((std::string(letters) + digits + ".").c_str());
    DefineOprtChars("+-*/^");
    DefineInfixOprtChars("+-");
  }
  void InitConst() override {}
  void InitOprt() override {
    DefineOprt("+", append_binary<Operation::add>, mu::prADD_SUB);
    DefineOprt("-", append_binary<Operation::subtract>, mu::prADD_SUB);
    DefineOprt("*", append_binary<Operation::multiply>, mu::prMUL_DIV);
    DefineOprt("/", append_binary<Operation::divide>, mu::prMUL_DIV);
    DefineOprt("^", append_binary<Operation::power>, mu::prPOW, mu::oaRIGHT);
    DefineInfixOprt("-", append_unary<Operation::negate>, mu::prINFIX, false);
    DefineInfixOprt("+", unary_plus, mu::prINFIX, false);
  }
  void InitFun() override {
    define<Operation::sqrt>();
    define<Operation::exp>();
    define<Operation::log>();
    define<Operation::log10>();
    define<Operation::sin>();
    define<Operation::cos>();
    define<Operation::tan>();
    define<Operation::asin>();
    define<Operation::acos>();
    define<Operation::atan>();
    define<Operation::sinh>();
    define<Operation::cosh>();
    define<Operation::tanh>();
    define<Operation::abs>();
    DefineFun("hypot", append_binary<Operation::hypot>, false);
    DefineFun("atan2", append_binary<Operation::atan2>, false);
    DefineFun("min", append_chain<Operation::minimum>, false);
    DefineFun("max", append_chain<Operation::maximum>, false);
  }
  template <Operation operation>
  void define() {
    DefineFun(std::string(operation_name(operation)), append_unary<operation>, false);
  }
};

const std::vector<std::string>& function_names() {
  static const std::vector<std::string> names = [] {
    const TapeParser parser;
    std::vector<std::string> result;
    for (const auto& [name, callback] : parser.GetFunDef()) result.push_back(name);
    return result;
  }();
  return names;
}

bool is_function(std::string_view name) {
  const auto& names = function_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_constant(std::string_view name) { return name == "pi" || name == "rad"; }

/// Finds what muParser would not say clearly, or takes for something else: it has conditions,
/// comparisons, assignments and strings, none of which a tape can hold.
class Scanner {
 public:
  Scanner(const std::string& text, const ArgumentNames& names) : text_(text), names_(names) {}

  std::vector<FormulaError> scan() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == ' ' || c == '\t' || c == '\n' || c == '\r')
        ++at_;
      else if (std::string_view(letters).find(c) != std::string_view::npos)
        scan_name();
      else if (std::string_view("0123456789.").find(c) != std::string_view::npos)
        scan_number();
      else
        scan_sign();
    }
    if (!any_ && errors_.empty()) errors_.push_back({0, "the formula is empty"});
    return std::move(errors_);
  }

 private:
  void complain(std::string message) { errors_.push_back({at_, std::move(message)}); }

  void scan_number() {
    double value = 0;
    const char* begin = text_.data() + at_;
    const char* stop = read_number(begin, text_.data() + text_.size(), value);
    auto length = static_cast<std::size_t>(stop - begin);
    if (length == 0) {
      length = std::max<std::size_t>(
          1, std::min(text_.find_first_not_of("0123456789.eE", at_), text_.size()) - at_);
      complain(fmt::format("'{}' is not a number", text_.substr(at_, length)));
    }
    number_ = text_.substr(at_, length);
    at_ += length;
    any_ = true;
  }

  void scan_name() {
    const std::size_t end =
        std::min(text_.find_first_not_of(std::string(letters) + digits + ".", at_), text_.size());
    const std::string name = text_.substr(at_, end - at_);
    const std::size_t next = text_.find_first_not_of(" \t\n\r", end);
    const bool called = next != std::string::npos && text_[next] == '(';
    if (is_function(name) && !called)
      complain(fmt::format("'{0}' is a function; expected {0}(...)", name));
    else if (called && !is_function(name))
      complain(
          fmt::format("there is no function '{}'{}", name, suggestion(name, function_names())));
    else if (!called && !is_constant(name) && !names_.contains(name))
      complain_of_unknown(name);
    number_.clear();
    any_ = true;
    at_ = end;
  }

  void complain_of_unknown(const std::string& name) {
    if (!number_.empty() && si_unit(name))
      return complain(
          fmt::format("numbers in a formula have no unit; make '{} {}' one of the "
                      "quantities",
                      number_, name));
    std::vector<std::string> known = {"pi", "rad"};
    for (const auto& [argument, index] : names_) known.push_back(argument);
    std::vector<std::string> components;
    for (const auto& [argument, index] : names_)
      if (argument.starts_with(name + ".")) components.push_back(argument);
    if (components.size() > 1)
      return complain(fmt::format("'{}' has several components; expected one of {}", name,
                                  fmt::join(components, ", ")));
    complain(fmt::format("unknown name '{}'{}", name, suggestion(name, known)));
  }

  void scan_sign() {
    const char c = text_[at_];
    if (text_.compare(at_, 2, "**") == 0)
      complain("'**' is written '^' in a formula");
    else if (c == '?' || c == ':' || c == '<' || c == '>' || c == '=' || c == '!' || c == '&' ||
             c == '|')
      complain(fmt::format("'{}': a formula has no conditions, comparisons or assignments", c));
    else if (std::string_view("+-*/^(),").find(c) == std::string_view::npos)
      complain(fmt::format("'{}' cannot stand in a formula", character()));
    at_ += errors_.empty() || errors_.back().offset != at_ ? 1 : skip();
    number_.clear();
    any_ = true;
  }
  /// The whole character, of however many bytes.
  std::string character() const {
    std::size_t end = at_ + 1;
    while (end < text_.size() && (static_cast<unsigned char>(text_[end]) & 0xc0u) == 0x80u) ++end;
    return text_.substr(at_, end - at_);
  }
  /// What a sign that was complained of makes up: "==", "**", one letter of another alphabet.
  std::size_t skip() const {
    const bool doubled = at_ + 1 < text_.size() &&
                         std::string_view("=*&|").find(text_[at_ + 1]) != std::string_view::npos;
    return doubled ? 2 : character().size();
  }

  const std::string& text_;
  const ArgumentNames& names_;
  std::vector<FormulaError> errors_;
  std::size_t at_ = 0;
  std::string number_;  ///< just before, if there was one
  bool any_ = false;
};

/// A mistake in grammar, where muParser found it.
FormulaError grammar_error(const mu::ParserError& error, const std::string& text) {
  const auto position = static_cast<std::size_t>(std::max(0, error.GetPos()));
  const std::size_t offset = std::min(position, text.size());
  // With all that follows, where it is an operator.
  const bool is_operator = error.GetToken().find_first_of("+-*/^") == 0;
  const std::string token = error.GetToken().substr(0, is_operator ? 1 : std::string::npos);
  switch (error.GetCode()) {
    case mu::ecUNEXPECTED_EOF:
      return {text.size(), "the formula ends too soon"};
    case mu::ecMISSING_PARENS:
      return {text.size(), "a ')' is missing"};
    case mu::ecTOO_FEW_PARAMS:
      return {offset, fmt::format("'{}' needs more arguments", token)};
    case mu::ecTOO_MANY_PARAMS:
      return {offset, fmt::format("'{}' has too many arguments", token)};
    case mu::ecUNEXPECTED_ARG:
    case mu::ecUNEXPECTED_ARG_SEP:
      return {offset, "a ',' can stand between a function's arguments only"};
    case mu::ecUNEXPECTED_VAL:
    case mu::ecUNEXPECTED_VAR:
    case mu::ecUNEXPECTED_FUN:
      return {offset, fmt::format("unexpected '{}'; is an operator missing before it?", token)};
    default:
      return {offset, token.empty() ? "the formula cannot be read from here"
                                    : fmt::format("unexpected '{}'", token)};
  }
}

}  // namespace

bool is_formula_name(std::string_view name) {
  return !name.empty() && name.size() <= 100 &&
         std::string_view(letters).find(name.front()) != std::string_view::npos &&
         name.find_first_not_of(std::string(letters) + digits) == std::string_view::npos;
}

bool is_formula_word(std::string_view name) { return is_function(name) || is_constant(name); }

std::vector<FormulaError> parse_formula(const std::string& text, const ArgumentNames& names,
                                        Tape& tape, Tape::Index& result) {
  if (text.size() > longest_formula)
    return {{0, fmt::format("a formula has at most {} characters", longest_formula)}};
  std::vector<FormulaError> errors = Scanner(text, names).scan();
  if (!errors.empty()) return errors;
  TapeParser parser;
  std::vector<double> numbers;
  numbers.reserve(names.size() + 2);
  const auto define = [&](const std::string& name, Tape::Index node) {
    if (name.find_first_of(letters) != 0 ||
        name.find_first_not_of(parser.ValidNameChars()) != std::string::npos)
      return;  // no formula can name it
    numbers.push_back(number_of(node));
    parser.DefineVar(name, &numbers.back());
  };
  building = &tape;
  try {
    for (const auto& [name, index] : names) define(name, index);
    if (text.find("pi") != std::string::npos) define("pi", tape.add_constant(std::numbers::pi));
    if (text.find("rad") != std::string::npos) define("rad", tape.add_radian());
    parser.SetExpr(text);
    int results = 0;
    const double* nodes = parser.Eval(results);
    if (results == 1)
      result = node_of(nodes[0]);
    else
      errors.push_back({text.find(','), "a ',' can stand between a function's arguments only"});
  } catch (const mu::ParserError& error) {
    errors.push_back(grammar_error(error, text));
  }
  building = nullptr;
  return errors;
}

}  // namespace ilss
