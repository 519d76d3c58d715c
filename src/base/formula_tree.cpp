#include "base/formula_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {

bool FormulaTree::can_branch(Op op) {
  switch (op) {
    case Op::less:
    case Op::less_equal:
    case Op::greater:
    case Op::greater_equal:
    case Op::equal:
    case Op::unequal:
    case Op::both:
    case Op::either:
    case Op::sign:
    case Op::rint:
    case Op::abs:
    case Op::min:
    case Op::max:
      return true;
    default:
      return false;
  }
}

TimeJet FormulaTree::at(double x, double y, double z, double t, double side) const {
  const Number number = evaluate({{x, y, z, t}, side}).back();
  return {number.value, number.rate, number.acceleration};
}

void FormulaTree::branches(Branches which, const std::array<double, 3>& X, double t, std::vector<double>& into) const {
  into.clear();
  const std::vector<Number> numbers = evaluate({{X[0], X[1], X[2], t}, t});
  for (const int n : nodes_of(which)) into.push_back(branch(nodes_[n], numbers));
}

std::vector<double> FormulaTree::linear_crossings(double end) const {
  const auto at = [&](double t) { return evaluate({{0.0, 0.0, 0.0, t}, t}); };
  const std::vector<Number> first = at(0.0), middle = at(0.4 * end), last = at(end);
  std::vector<double> times;
  for (const int n : timed_) {
    const auto& arguments = nodes_[n].arguments;
    if (arguments.size() > 2) continue;
    // The expression whose sign decides the branch: the argument of abs and sign, the difference of the sides of a
    // comparison.
    const auto height = [&](const std::vector<Number>& numbers, double Number::*part) {
      return numbers[arguments[0]].*part - (arguments.size() == 2 ? numbers[arguments[1]].*part : 0.0);
    };
    const double rate = height(first, &Number::rate);
    if (rate == 0.0 || height(middle, &Number::rate) != rate || height(last, &Number::rate) != rate) continue;
    const double t = -height(first, &Number::value) / rate;
    if (t > 0.0 && t < end) times.push_back(t);
  }
  return times;
}

// A number that identifies the branch.
double FormulaTree::branch(const Node& node, const std::vector<Number>& known) {
  if (node.op == Op::abs) return std::signbit(known[node.arguments[0]].side) ? -1.0 : 1.0;
  if (node.op != Op::min && node.op != Op::max) return function(node, known).side;
  std::size_t taken = 0;
  double extreme = 0.0;
  for (std::size_t a = 0; a < node.arguments.size(); ++a) {
    const double value = known[node.arguments[a]].side;
    if (a > 0 && !(node.op == Op::min ? value < extreme : value > extreme)) continue;
    extreme = value;
    taken = a;
  }
  return static_cast<double>(taken);
}

std::vector<FormulaTree::Number> FormulaTree::evaluate(const Place& place) const {
  std::vector<Number> numbers;
  numbers.reserve(nodes_.size());
  for (const Node& node : nodes_) numbers.push_back(evaluate(node, place, numbers));
  return numbers;
}

FormulaTree::Number FormulaTree::evaluate(const Node& node, const Place& place, const std::vector<Number>& known) {
  switch (node.op) {
    case Op::constant:
      return {node.constant, 0.0, 0.0, node.constant};
    case Op::x:
    case Op::y:
    case Op::z: {
      const double value = place.at[static_cast<std::size_t>(node.op) - static_cast<std::size_t>(Op::x)];
      return {value, 0.0, 0.0, value};
    }
    case Op::t:
      return {place.at[3], 1.0, 0.0, place.side};
    case Op::choose:
      return known[node.arguments[known[node.arguments[0]].side != 0.0 ? 1 : 2]];
    case Op::sum:
    case Op::avg:
    case Op::min:
    case Op::max:
      return of_many(node, known);
    default:
      return function(node, known);
  }
}

FormulaTree::Number FormulaTree::of_many(const Node& node, const std::vector<Number>& known) {
  Number result = known[node.arguments[0]];
  for (std::size_t a = 1; a < node.arguments.size(); ++a) {
    const Number& next = known[node.arguments[a]];
    if (node.op == Op::min || node.op == Op::max) {
      if (node.op == Op::min ? next.side < result.side : next.side > result.side) result = next;
      continue;
    }
    result.value += next.value;
    result.rate += next.rate;
    result.acceleration += next.acceleration;
    result.side += next.side;
  }
  if (node.op != Op::avg) return result;
  const double share = 1.0 / static_cast<double>(node.arguments.size());
  return {share * result.value, share * result.rate, share * result.acceleration, share * result.side};
}

FormulaTree::Number FormulaTree::chain(const Number& a, double value, double first, double second, double side) {
  if (a.rate == 0.0 && a.acceleration == 0.0) return {value, 0.0, 0.0, side};
  return {value, first * a.rate, second * a.rate * a.rate + first * a.acceleration, side};
}

FormulaTree::Number FormulaTree::elementary(Op op, const Number& a) {
  const double f = a.value;
  const auto of_a = [&](double value, double first, double second, double side) {
    return chain(a, value, first, second, side);
  };
  switch (op) {
    case Op::sin:
      return of_a(std::sin(f), std::cos(f), -std::sin(f), std::sin(a.side));
    case Op::cos:
      return of_a(std::cos(f), -std::sin(f), -std::cos(f), std::cos(a.side));
    case Op::tan: {
      const double g = std::tan(f), slope = 1.0 + g * g;
      return of_a(g, slope, 2.0 * g * slope, std::tan(a.side));
    }
    case Op::asin: {
      const double c = 1.0 / std::sqrt(1.0 - f * f);
      return of_a(std::asin(f), c, f * c * c * c, std::asin(a.side));
    }
    case Op::acos: {
      const double c = 1.0 / std::sqrt(1.0 - f * f);
      return of_a(std::acos(f), -c, -f * c * c * c, std::acos(a.side));
    }
    case Op::atan: {
      const double c = 1.0 / (1.0 + f * f);
      return of_a(std::atan(f), c, -2.0 * f * c * c, std::atan(a.side));
    }
    case Op::sinh:
      return of_a(std::sinh(f), std::cosh(f), std::sinh(f), std::sinh(a.side));
    case Op::cosh:
      return of_a(std::cosh(f), std::sinh(f), std::cosh(f), std::cosh(a.side));
    case Op::tanh: {
      const double g = std::tanh(f), slope = 1.0 - g * g;
      return of_a(g, slope, -2.0 * g * slope, std::tanh(a.side));
    }
    case Op::asinh: {
      const double c = 1.0 / std::sqrt(1.0 + f * f);
      return of_a(std::asinh(f), c, -f * c * c * c, std::asinh(a.side));
    }
    case Op::acosh: {
      const double c = 1.0 / std::sqrt(f * f - 1.0);
      return of_a(std::acosh(f), c, -f * c * c * c, std::acosh(a.side));
    }
    case Op::atanh: {
      const double c = 1.0 / (1.0 - f * f);
      return of_a(std::atanh(f), c, 2.0 * f * c * c, std::atanh(a.side));
    }
    case Op::log2:
      return of_a(std::log2(f), 1.0 / (f * std::numbers::ln2), -1.0 / (f * f * std::numbers::ln2), std::log2(a.side));
    case Op::log10:
      return of_a(std::log10(f), 1.0 / (f * std::numbers::ln10), -1.0 / (f * f * std::numbers::ln10),
                  std::log10(a.side));
    case Op::ln:
      return of_a(std::log(f), 1.0 / f, -1.0 / (f * f), std::log(a.side));
    case Op::exp:
      return of_a(std::exp(f), std::exp(f), std::exp(f), std::exp(a.side));
    case Op::sqrt: {
      const double g = std::sqrt(f);
      return of_a(g, 0.5 / g, -0.25 / (g * f), std::sqrt(a.side));
    }
    default:
      return {};
  }
}

FormulaTree::Number FormulaTree::function(const Node& node, const std::vector<Number>& known) {
  const Number a = known[node.arguments[0]];
  const Number b = node.arguments.size() > 1 ? known[node.arguments[1]] : Number{};
  // A node with the same value on either side of t.
  const auto step = [](double value) { return Number{value, 0.0, 0.0, value}; };
  const auto truth = [&](bool value) { return step(value ? 1.0 : 0.0); };
  const double f = a.value;
  switch (node.op) {
    case Op::negate:
      return {-f, -a.rate, -a.acceleration, -a.side};
    case Op::add:
      return {f + b.value, a.rate + b.rate, a.acceleration + b.acceleration, a.side + b.side};
    case Op::subtract:
      return {f - b.value, a.rate - b.rate, a.acceleration - b.acceleration, a.side - b.side};
    case Op::multiply:
      return {f * b.value, a.rate * b.value + f * b.rate,
              a.acceleration * b.value + 2.0 * a.rate * b.rate + f * b.acceleration, a.side * b.side};
    case Op::divide: {
      const double q = f / b.value, rate = (a.rate - q * b.rate) / b.value;
      return {q, rate, (a.acceleration - 2.0 * rate * b.rate - q * b.acceleration) / b.value, a.side / b.side};
    }
    case Op::power: {
      const double p = b.value, value = std::pow(f, p), side = std::pow(a.side, b.side);
      if (b.rate == 0.0 && b.acceleration == 0.0) {
        const double first = p == 0.0 ? 0.0 : p * std::pow(f, p - 1.0);
        const double second = p == 0.0 || p == 1.0 ? 0.0 : p * (p - 1.0) * std::pow(f, p - 2.0);
        return chain(a, value, first, second, side);
      }
      // exp(l), l = b ln(a)
      const double log = std::log(f), relative = a.rate / f;
      const double rate = b.rate * log + p * relative;
      const double acceleration =
          b.acceleration * log + 2.0 * b.rate * relative + p * (a.acceleration / f - relative * relative);
      return {value, value * rate, value * (rate * rate + acceleration), side};
    }
    case Op::less:
      return truth(a.side < b.side);
    case Op::less_equal:
      return truth(a.side <= b.side);
    case Op::greater:
      return truth(a.side > b.side);
    case Op::greater_equal:
      return truth(a.side >= b.side);
    case Op::equal:
      return truth(a.side == b.side);
    case Op::unequal:
      return truth(a.side != b.side);
    case Op::both:
      return truth(a.side != 0.0 && b.side != 0.0);
    case Op::either:
      return truth(a.side != 0.0 || b.side != 0.0);
    case Op::sign:
      return step(a.side < 0.0 ? -1.0 : (a.side > 0.0 ? 1.0 : 0.0));
    case Op::rint:
      return step(std::floor(a.side + 0.5));
    case Op::abs:
      return std::signbit(a.side) ? Number{-f, -a.rate, -a.acceleration, -a.side} : a;
    case Op::atan2: {
      const double square = f * f + b.value * b.value;
      const double turned = b.value * a.rate - f * b.rate;
      const double along = b.value * b.rate + f * a.rate;
      return {std::atan2(f, b.value), turned / square,
              (b.value * a.acceleration - f * b.acceleration) / square - 2.0 * turned * along / (square * square),
              std::atan2(a.side, b.side)};
    }
    default:
      return elementary(node.op, a);
  }
}

}  // namespace pliant
