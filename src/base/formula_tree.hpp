/// Formulas as trees: their derivatives with respect to t, and where they have kinks.
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

/// A formula in x, y, z, t in muParser's grammar. Derivatives are exact but for rounding: each operation carries them
/// along. At a kink or a jump (of min, max, abs, sign, rint, comparisons, `? :`) they are those of one side.
class FormulaTree {
 public:
  /// `text`: one that muParser accepts, with the constant `pi`. Throws ExpressionError at what is not understood.
  explicit FormulaTree(const std::string& text);

  /// At (x, y, z, t). What branches, branches as it does at the time `side`, which lies near t on the side that is
  /// wanted.
  TimeJet at(double x, double y, double z, double t, double side) const;
  /// Which branches the formula takes at a time, as far as they do not depend on the place: one number each.
  void branches(double t, std::vector<double>& into) const;
  /// Whether there are any.
  bool has_branches() const { return !timed_.empty(); }

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
    bool depends_on_space = false;
  };
  /// Value and derivatives at t, and the value at the side.
  struct Number {
    double value = 0.0, rate = 0.0, acceleration = 0.0, side = 0.0;
  };
  struct Place {
    std::array<double, 4> at{};
    double side = 0.0;
  };
  class Reader;

  static bool can_branch(Op op);
  /// Of all nodes, one after another: formulas are long, and the stack is not.
  std::vector<Number> evaluate(const Place& place) const;
  static Number evaluate(const Node& node, const Place& place, const std::vector<Number>& known);
  static Number function(const Node& node, const std::vector<Number>& known);
  static Number of_many(const Node& node, const std::vector<Number>& known);
  static double branch(const Node& node, const std::vector<Number>& known);

  std::vector<Node> nodes_;  // arguments before what they are arguments of
  std::vector<int> timed_;   // nodes that branch in time alone
};

}  // namespace pliant
