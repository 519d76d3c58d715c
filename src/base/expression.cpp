#include "base/expression.hpp"

#include "base/formula_tree.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <regex>
#include <vector>

#include <muParser.h>

namespace pliant {
namespace {

constexpr std::array variable_names{"x", "y", "z", "t"};
constexpr std::size_t time_index = 3;

/// Position of muParser's assignment operator, which would let a formula change its own variables.
std::size_t assignment_position(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
    } else if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) {
      return i;
    }
  }
  return std::string::npos;
}

bool is_name_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// The name or symbol at `position`.
std::string token_at(const std::string& text, std::size_t position) {
  std::size_t end = position;
  while (end < text.size() && is_name_character(text[end])) ++end;
  if (end == position) {  // a symbol: up to the next blank
    while (end < text.size() && std::isspace(static_cast<unsigned char>(text[end])) == 0) ++end;
  }
  return excerpt(text.substr(position, end - position), 20);
}

/// Start of the name that ends before `position`; `position` itself if there is none.
std::size_t start_of_name(const std::string& text, std::size_t position) {
  while (position > 0 && is_name_character(text[position - 1])) --position;
  return position;
}

bool has_decimal_comma(const std::string& text) {
  static const std::regex comma(R"(\d,\d)");
  return text.find('(') == std::string::npos && std::regex_search(text, comma);
}

/// What to write instead of an operator in words.
std::string operator_for(const std::string& token) {
  if (token == "and") return " ('and' is written '&&')";
  if (token == "or") return " ('or' is written '||')";
  return "";
}

std::vector<std::string> known_names(const mu::Parser& parser) {
  std::vector<std::string> names(variable_names.begin(), variable_names.end());
  for (const auto& constant : parser.GetConst()) names.push_back(constant.first);
  for (const auto& function : parser.GetFunDef()) names.push_back(function.first);
  return names;
}

ExpressionError explained(const mu::ParserError& error, const mu::Parser& parser, const std::string& text) {
  const int position = std::clamp(static_cast<int>(error.GetPos()), 0, static_cast<int>(text.size()));
  const auto at = static_cast<std::size_t>(position);
  const std::size_t start = start_of_name(text, at);
  const std::string token = token_at(text, at);
  const auto because = [&](const std::string& message) { return ExpressionError(message, position); };
  switch (error.GetCode()) {
    case mu::ecEMPTY_EXPRESSION:
      return because("the formula is empty");
    case mu::ecEXPRESSION_TOO_LONG:
      return because("the formula is too long");
    case mu::ecUNASSIGNABLE_TOKEN:
      if (parser.GetFunDef().contains(token)) return because("function '" + token + "' needs its arguments in '( )'");
      return because("'" + token + "' is not known; a formula has x, y, z, t, pi and functions" +
                     did_you_mean(token, known_names(parser)));
    case mu::ecUNEXPECTED_OPERATOR:
      return because("operator '" + error.GetToken() + "' is not expected here" +
                     (text.find("**") != std::string::npos ? " (a power is written '^')" : ""));
    case mu::ecUNEXPECTED_EOF:
    case mu::ecINTERNAL_ERROR:  // of "-"
      return because("the formula ends too early");
    case mu::ecUNEXPECTED_VAL:
    case mu::ecUNEXPECTED_VAR:
    case mu::ecUNEXPECTED_FUN:
      return because("an operator is missing before '" + token + "'" +
                     (has_decimal_comma(text) ? " (a decimal point is written '.')" : operator_for(token)));
    case mu::ecMISSING_PARENS:
      return because("a ')' is missing");
    case mu::ecUNEXPECTED_PARENS:
      if (start < at && error.GetToken() == "(") {
        const std::string name = token_at(text, start);
        return {"'" + name + "' is not a function" + did_you_mean(name, known_names(parser)), static_cast<int>(start)};
      }
      return because("parenthesis '" + error.GetToken() + "' is not expected here");
    case mu::ecTOO_FEW_PARAMS:
      return because("function '" + error.GetToken() + "' needs more arguments");
    case mu::ecTOO_MANY_PARAMS:
      return because("function '" + error.GetToken() + "' has too many arguments");
    case mu::ecUNEXPECTED_STR:
    case mu::ecSTR_RESULT:
    case mu::ecSTRING_EXPECTED:
    case mu::ecVAL_EXPECTED:
      return because("a formula holds no quotes");
    default:
      return because(error.GetMsg());
  }
}

/// Finds the times at which a formula changes branch, where it is not as smooth as time integration needs.
class KinkSearch {
 public:
  /// Times that are the same at all places; the end may be one.
  KinkSearch(const FormulaTree& formula, bool uses_space, double end, double interval)
      : formula_(formula),
        end_(end),
        latest_(end * (1.0 + 2.0 * same)),
        interval_(interval),
        checked_{{0.0, 0.0, 0.0}} {
    // Places chosen so that formulas with round numbers do not vanish there.
    if (uses_space) checked_.insert(checked_.end(), {{0.317, -0.539, 0.771}, {-13.7, 7.91, 23.3}});
    look_at(formula.linear_crossings(end));
  }
  /// Times at one place, before the end.
  KinkSearch(const FormulaTree& formula, const std::array<double, 3>& X, double end, double interval)
      : formula_(formula),
        which_(FormulaTree::Branches::in_place_and_time),
        X_(X),
        end_(end),
        latest_(end * (1.0 - nearness)),
        interval_(interval),
        checked_{X} {
    look_at({});
  }
  const std::vector<double>& found() const { return found_; }

 private:
  /// At times one interval apart, and at the given ones.
  void look_at(std::vector<double> times) {
    constexpr double most_samples = 1e6;
    const auto num_samples = static_cast<int>(std::clamp(std::ceil(end_ / interval_), 1.0, most_samples));
    for (int k = 1; k <= num_samples; ++k) times.push_back(end_ * k / num_samples);
    times.push_back(end_ * (1.0 + nearness));
    std::ranges::sort(times);
    std::vector<double> before, after;
    take_branches(0.0, before);
    double from = 0.0;
    for (const double to : times) {
      take_branches(to, after);
      look(from, before, to, after);
      std::swap(before, after);
      from = to;
    }
  }

  void take_branches(double t, std::vector<double>& into) const { formula_.branches(which_, X_, t, into); }

  void look(double from, const std::vector<double>& before, double to, const std::vector<double>& after) {
    if (before == after || num_changes_ >= most_changes) return;
    const double middle = 0.5 * (from + to);
    if (middle <= from || middle >= to) {
      ++num_changes_;
      add(rounded(to));
      return;
    }
    std::vector<double> between;
    take_branches(middle, between);
    look(from, before, middle, between);
    look(middle, between, to, after);
  }

  /// Rounds to a number of few digits if it differs by no more than the formula's rounding: 0.1, not 0.1 + 1e-17.
  static double rounded(double t) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.13g", t);
    const double round = std::strtod(digits, nullptr);
    return std::abs(round - t) <= same * t ? round : t;
  }

  void add(double t) {
    if (t <= nearness * end_ || t > latest_) return;
    if (!found_.empty() && t <= found_.back() * (1.0 + 2.0 * same)) return;
    if (is_kink(t)) found_.push_back(t);
  }

  // Relative to the values over the whole time: a smaller change is rounding.
  bool is_kink(double t) const {
    const double aside = std::max(nearness * interval_, 8.0 * same * t);
    return std::ranges::any_of(checked_, [&](const std::array<double, 3>& X) {
      const auto& [x, y, z] = X;
      const TimeJet l = formula_.at(x, y, z, t, t - aside), r = formula_.at(x, y, z, t, t + aside);
      const auto size = [&](double value, double rate, double acceleration) {
        return std::abs(value) + end_ * std::abs(rate) + end_ * end_ * std::abs(acceleration);
      };
      const double jump = size(l.value - r.value, l.rate - r.rate, l.acceleration - r.acceleration);
      constexpr double rounding = 1e-10;
      return !(jump <= rounding * (size(l.value, l.rate, l.acceleration) + size(r.value, r.rate, r.acceleration)));
    });
  }

  static constexpr double same = 1e-14, nearness = 1e-7;
  static constexpr int most_changes = 20000;  // a formula with more is noise

  const FormulaTree& formula_;
  FormulaTree::Branches which_ = FormulaTree::Branches::in_time;
  std::array<double, 3> X_{};
  double end_, latest_, interval_;
  std::vector<std::array<double, 3>> checked_;  // sample places; a kink counts if one of them shows it
  int num_changes_ = 0;
  std::vector<double> found_;
};

}  // namespace

/// A parsed formula. Variables are bound by address, so a formula must not move.
struct Expression::Formula {
  Formula(std::string formula_text, double formula_factor) : text(std::move(formula_text)), factor(formula_factor) {
    for (std::size_t i = 0; i < variable_names.size(); ++i) parser.DefineVar(variable_names[i], &variables[i]);
    parser.DefineConst("pi", std::numbers::pi);
    // muParser's own have 13 digits.
    parser.DefineConst("_pi", std::numbers::pi);
    parser.DefineConst("_e", std::numbers::e);
    try {
      parser.SetExpr(text);
      for (const auto& used : parser.GetUsedVar()) {
        (used.second == &variables[time_index] ? uses_time : uses_space) = true;
      }
      parser.Eval();
    } catch (const mu::ParserError& error) {
      throw explained(error, parser, text);
    }
    if (parser.GetNumResults() != 1) {
      throw ExpressionError("a formula has one value, not several separated by ',' (a decimal point is written '.')",
                            static_cast<int>(std::min(text.find(','), text.size())));
    }
    FormulaTree read(text);
    if (uses_time) tree = std::move(read);
  }
  Formula(const Formula&) = delete;
  Formula& operator=(const Formula&) = delete;

  std::string text;
  double factor;
  std::array<double, 4> variables{};
  mu::Parser parser;
  bool uses_space = false;
  bool uses_time = false;
  std::optional<FormulaTree> tree;  // only if it depends on time
};

Expression::Expression() = default;

Expression::Expression(double constant) : constant_(constant) {}

Expression::Expression(const std::string& text, double factor) {
  const std::size_t assignment = assignment_position(text);
  if (assignment != std::string::npos) {
    throw ExpressionError("a formula cannot assign with '='; equality is tested with '=='",
                          static_cast<int>(assignment));
  }
  auto formula = std::make_unique<Formula>(text, factor);
  if (formula->uses_space || formula->uses_time) {
    formula_ = std::move(formula);
  } else {
    constant_ = factor * formula->parser.Eval();
  }
}

/// What all copies of a replaceable formula follow.
struct Expression::Source {
  Expression current;
  std::uint64_t version = 0;
};

Expression::Expression(const Expression& other)
    : source_(other.source_), scale_(other.scale_), version_(other.version_) {
  set(other, 1.0);
}

Expression& Expression::operator=(const Expression& other) {
  if (this != &other) *this = Expression(other);
  return *this;
}

Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Expression::~Expression() = default;

void Expression::set(const Expression& from, double factor) const {
  constant_ = factor * from.constant_;
  formula_ = from.formula_ ? std::make_unique<Formula>(from.formula_->text, factor * from.formula_->factor) : nullptr;
}

void Expression::take_over() const {
  if (version_ == source_->version) return;
  set(source_->current, scale_);
  version_ = source_->version;
}

Expression Expression::scaled(double factor) const {
  Expression result = *this;
  result.set(frozen(), factor);
  result.scale_ = factor * scale_;
  return result;
}

void Expression::make_replaceable() {
  if (source_ != nullptr) return;
  const Expression current = *this;
  source_ = std::make_shared<Source>();
  source_->current = current;
}

void Expression::replace(const Expression& by) const {
  source_->current = by.frozen();
  ++source_->version;
}

Expression Expression::frozen() const {
  update();
  Expression result;
  result.set(*this, 1.0);
  return result;
}

double Expression::operator()(double x, double y, double z, double t) const {
  update();
  if (!formula_) return constant_;
  formula_->variables = {x, y, z, t};
  return formula_->factor * formula_->parser.Eval();
}

TimeJet Expression::derivatives(double x, double y, double z, double t, double side) const {
  if (!depends_on_time()) return {(*this)(x, y, z, t), 0.0, 0.0};
  const TimeJet jet = formula_->tree->at(x, y, z, t, side);
  const double factor = formula_->factor;
  return {factor * jet.value, factor * jet.rate, factor * jet.acceleration};
}

std::vector<double> Expression::kinks(double end, double interval) const {
  if (!depends_on_time() || !formula_->tree->has(FormulaTree::Branches::in_time)) return {};
  const KinkSearch search(*formula_->tree, formula_->uses_space, end, interval);
  return search.found();
}

std::vector<double> Expression::kinks_at(const std::array<double, 3>& X, double end, double interval) const {
  if (!depends_on_time() || !formula_->tree->has(FormulaTree::Branches::in_place_and_time)) return {};
  const KinkSearch search(*formula_->tree, X, end, interval);
  return search.found();
}

bool Expression::depends_on_space() const {
  update();
  return formula_ && formula_->uses_space;
}
bool Expression::depends_on_time() const {
  update();
  return formula_ && formula_->uses_time;
}
bool Expression::is_zero() const {
  update();
  return !formula_ && constant_ == 0.0;
}
std::string Expression::text() const {
  update();
  return formula_ ? formula_->text : format_number(constant_);
}

}  // namespace pliant
