#include "base/expression.hpp"
#include "base/formula_tree.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <numbers>
#include <optional>
#include <string_view>

namespace pliant {

/// Recursive descent with muParser's precedence: ?: || && comparisons + - * / signs ^, the last one right-associative.
/// One comparison alone: users mean another thing than muParser by several.
class FormulaTree::Reader {
 public:
  Reader(const std::string& text, std::vector<Node>& nodes) : text_(text), nodes_(nodes) {}

  void read() {
    choice();
    skip_blanks();
    if (at_ != text_.size()) fail();
  }

 private:
  struct Operator {
    std::string_view symbol;
    Op op;
  };

  [[noreturn]] void fail() const {
    throw ExpressionError("the formula cannot be differentiated in time from here on", static_cast<int>(at_));
  }
  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool accept(std::string_view symbol) {
    skip_blanks();
    if (text_.compare(at_, symbol.size(), symbol) != 0) return false;
    at_ += symbol.size();
    return true;
  }
  void expect(std::string_view symbol) {
    if (!accept(symbol)) fail();
  }
  template <std::size_t N>
  std::optional<Op> accept_one(const std::array<Operator, N>& operators) {
    for (const auto& [symbol, op] : operators) {
      if (accept(symbol)) return op;
    }
    return std::nullopt;
  }

  int add(Op op, std::vector<int> arguments, double constant = 0.0) {
    Node node{op, constant, std::move(arguments)};
    node.depends_on_space = op == Op::x || op == Op::y || op == Op::z ||
                            std::ranges::any_of(node.arguments, [&](int a) { return nodes_[a].depends_on_space; });
    node.depends_on_time =
        op == Op::t || std::ranges::any_of(node.arguments, [&](int a) { return nodes_[a].depends_on_time; });
    nodes_.push_back(std::move(node));
    return static_cast<int>(nodes_.size()) - 1;
  }
  template <std::size_t N, class Operand>
  int from_the_left(const std::array<Operator, N>& operators, Operand operand) {
    int left = operand();
    while (const auto op = accept_one(operators)) left = add(*op, {left, operand()});
    return left;
  }

  /// While it lives, the parser is one level deeper.
  class Level {
   public:
    explicit Level(Reader& reader) : reader_(reader) {
      constexpr int most = 2500;
      if (++reader_.depth_ <= most) return;
      --reader_.depth_;
      throw ExpressionError("the formula is nested too deeply", static_cast<int>(reader_.at_));
    }
    ~Level() { --reader_.depth_; }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;

   private:
    Reader& reader_;
  };

  int choice() {
    const Level level(*this);
    const int condition = disjunction();
    if (!accept("?")) return condition;
    const int yes = choice();
    expect(":");
    return add(Op::choose, {condition, yes, choice()});
  }
  int disjunction() {
    return from_the_left(std::array{Operator{"||", Op::either}}, [this] { return conjunction(); });
  }
  int conjunction() {
    return from_the_left(std::array{Operator{"&&", Op::both}}, [this] { return comparison(); });
  }
  int comparison() {
    // Longer symbols first.
    static constexpr std::array operators{Operator{"<=", Op::less_equal}, Operator{">=", Op::greater_equal},
                                          Operator{"==", Op::equal},      Operator{"!=", Op::unequal},
                                          Operator{"<", Op::less},        Operator{">", Op::greater}};
    const int left = sum();
    const auto op = accept_one(operators);
    if (!op) return left;
    const int result = add(*op, {left, sum()});
    skip_blanks();
    const auto next = static_cast<int>(at_);
    if (accept_one(operators)) {
      throw ExpressionError("the result of a comparison, 0 or 1, is compared: 'a < b < c' is written 'a < b && b < c'",
                            next);
    }
    return result;
  }
  int sum() {
    static constexpr std::array operators{Operator{"+", Op::add}, Operator{"-", Op::subtract}};
    return from_the_left(operators, [this] { return product(); });
  }
  int product() {
    static constexpr std::array operators{Operator{"*", Op::multiply}, Operator{"/", Op::divide}};
    return from_the_left(operators, [this] { return with_sign(); });
  }
  int with_sign() {
    const Level level(*this);
    if (accept("-")) return add(Op::negate, {with_sign()});
    if (accept("+")) return with_sign();
    const int base = operand();
    return accept("^") ? add(Op::power, {base, with_sign()}) : base;
  }

  int operand() {
    skip_blanks();
    if (at_ == text_.size()) fail();
    if (accept("(")) {
      const int inner = choice();
      expect(")");
      return inner;
    }
    double number = 0.0;
    const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
    if (error == std::errc()) {
      at_ = static_cast<std::size_t>(end - text_.data());
      return add(Op::constant, {}, number);
    }
    return named();
  }
  int named() {
    const std::size_t start = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_'))
      ++at_;
    const std::string name = text_.substr(start, at_ - start);
    static const std::map<std::string, double, std::less<>> constants{
        {"pi", std::numbers::pi}, {"_pi", std::numbers::pi}, {"_e", std::numbers::e}};
    static const std::map<std::string, Op, std::less<>> variables{
        {"x", Op::x}, {"y", Op::y}, {"z", Op::z}, {"t", Op::t}};
    static const std::map<std::string, Op, std::less<>> functions{
        {"sin", Op::sin},     {"cos", Op::cos},     {"tan", Op::tan},     {"asin", Op::asin}, {"acos", Op::acos},
        {"atan", Op::atan},   {"atan2", Op::atan2}, {"sinh", Op::sinh},   {"cosh", Op::cosh}, {"tanh", Op::tanh},
        {"asinh", Op::asinh}, {"acosh", Op::acosh}, {"atanh", Op::atanh}, {"log2", Op::log2}, {"log10", Op::log10},
        {"log", Op::ln},      {"ln", Op::ln},       {"exp", Op::exp},     {"sqrt", Op::sqrt}, {"sign", Op::sign},
        {"rint", Op::rint},   {"abs", Op::abs},     {"sum", Op::sum},     {"avg", Op::avg},   {"min", Op::min},
        {"max", Op::max}};
    if (const auto constant = constants.find(name); constant != constants.end()) {
      return add(Op::constant, {}, constant->second);
    }
    if (const auto variable = variables.find(name); variable != variables.end()) return add(variable->second, {});
    const auto function = functions.find(name);
    if (function == functions.end()) {
      at_ = start;
      fail();
    }
    expect("(");
    std::vector<int> arguments;
    do arguments.push_back(choice());
    while (accept(","));
    expect(")");
    return add(function->second, std::move(arguments));
  }

  const std::string& text_;
  std::vector<Node>& nodes_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

FormulaTree::FormulaTree(const std::string& text) {
  Reader(text, nodes_).read();
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    if (!can_branch(node.op)) continue;
    if (!node.depends_on_space) {
      timed_.push_back(static_cast<int>(n));
    } else if (node.depends_on_time) {
      moving_.push_back(static_cast<int>(n));
    }
  }
}

}  // namespace pliant
