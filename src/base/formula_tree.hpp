/// Formulas as trees: their time derivatives, and where they have kinks.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace pliant {

/// A function of t and its first two derivatives.
struct TimeJet {
  double value = 0.0;
  double rate = 0.0;          ///< [1/s]
  double acceleration = 0.0;  ///< [1/s^2]
};

/// A formula in x, y, z, t in muParser's grammar. Derivatives are exact to rounding: each operation propagates them. At
/// a kink or a jump (of min, max, abs, sign, rint, comparisons, `? :`) they are one-sided.
class FormulaTree {
 public:
  /// `text`: a formula that muParser accepts, with the constant `pi`. Throws ExpressionError for anything that is not
  /// understood, and for comparisons of comparisons.
  explicit FormulaTree(const std::string& text);

  /// Value and derivatives at (x, y, z, t). Branches are taken as at the time `side`, which lies near t, on the side
  /// that is wanted.
  TimeJet at(double x, double y, double z, double t, double side) const;
  /// Which branch nodes: those that depend on t alone, or also on the place.
  enum class Branches { in_time, in_place_and_time };
  /// The branch that each such node takes, as one number each.
  void branches(Branches which, const std::array<double, 3>& X, double t, std::vector<double>& into) const;
  /// Whether the formula has such nodes.
  bool has(Branches which) const { return !nodes_of(which).empty(); }
  /// Times in (0, end) at which an expression linear in t changes branch, as at `t < 0.1` or `min(t/0.1, 1)`, unsorted.
  /// Without those that depend on the place.
  std::vector<double> linear_crossings(double end) const;

 private:
  enum class Op {
    constant,
    x,
    y,
    z,
    t,
    negate,
    add,
    subtract,
    multiply,
    divide,
    power,
    less,
    less_equal,
    greater,
    greater_equal,
    equal,
    unequal,
    both,
    either,
    choose,
    sin,
    cos,
    tan,
    asin,
    acos,
    atan,
    atan2,
    sinh,
    cosh,
    tanh,
    asinh,
    acosh,
    atanh,
    log2,
    log10,
    ln,
    exp,
    sqrt,
    sign,
    rint,
    abs,
    sum,
    avg,
    min,
    max
  };
  struct Node {
    Op op = Op::constant;
    double constant = 0.0;
    std::vector<int> arguments = {};
    bool depends_on_space = false, depends_on_time = false;
  };
  /// Value and derivatives at t, and the value at `side`.
  struct Number {
    double value = 0.0, rate = 0.0, acceleration = 0.0, side = 0.0;
  };
  struct Place {
    std::array<double, 4> at{};
    double side = 0.0;
  };
  class Reader;

  static bool can_branch(Op op);
  const std::vector<int>& nodes_of(Branches which) const { return which == Branches::in_time ? timed_ : moving_; }
  /// Evaluates all nodes in order, without recursion: a long formula would overflow the stack.
  std::vector<Number> evaluate(const Place& place) const;
  static Number evaluate(const Node& node, const Place& place, const std::vector<Number>& known);
  static Number function(const Node& node, const std::vector<Number>& known);
  /// A function of one argument, smooth except at single points.
  static Number elementary(Op op, const Number& a);
  /// g(a) from its value, its derivatives and its value at `side`; a constant argument stays constant even where g has
  /// no derivative.
  static Number chain(const Number& a, double value, double first, double second, double side);
  static Number of_many(const Node& node, const std::vector<Number>& known);
  static double branch(const Node& node, const std::vector<Number>& known);

  std::vector<Node> nodes_;  // arguments before the nodes that use them
  std::vector<int> timed_;   // nodes that branch in time alone
  std::vector<int> moving_;  // nodes that branch in time and place
};

}  // namespace pliant
