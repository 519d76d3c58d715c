#include "energy/rigid/joint_equation.hpp"

#include <cmath>

namespace pliant {
namespace {

/// A given value as the number type T has it: alone, or with its rates.
template <class T>
struct Given {
  static T of(const TimeSeries<double>& s) { return T(s.value); }
};
template <class T>
struct Given<TimeSeries<T>> {
  static TimeSeries<T> of(const TimeSeries<double>& s) { return {T(s.value), T(s.rate), T(s.acceleration)}; }
};

TimeSeries<double> cosine(const TimeSeries<double>& s) {
  const double c = std::cos(s.value), d = -std::sin(s.value);
  return {c, d * s.rate, d * s.acceleration - c * s.rate * s.rate};
}

TimeSeries<double> sine(const TimeSeries<double>& s) {
  const double c = std::sin(s.value), d = std::cos(s.value);
  return {c, d * s.rate, d * s.acceleration - c * s.rate * s.rate};
}

/// The value of an equation of each kind.
template <class T>
struct Evaluation {
  const BodyMotion<T>&a, &b;
  const TimeSeries<double>& given;

  T operator()(const Coincidence& c) const {
    const Vector3<T> d = apart(c.point);
    return c.normal[0] * d[0] + c.normal[1] * d[1] + c.normal[2] * d[2];
  }
  T operator()(const Perpendicularity& p) const { return dot(a.direction(p.a), b.direction(p.b)); }
  T operator()(const Travel& t) const {
    const T distance = dot(a.direction(t.normal), apart(t.point));
    return t.given ? distance - Given<T>::of(given) : distance;
  }
  T operator()(const Turn& t) const {
    const T c = Given<T>::of(cosine(given)), s = Given<T>::of(sine(given));
    return dot(b.direction(t.e), c * a.direction(t.f) - s * a.direction(t.e));
  }
  T operator()(const Distance& d) const {
    const auto between = b.point(d.b) - a.point(d.a);
    const T length = d.given ? T(d.at_start) + Given<T>::of(given) : T(d.at_start);
    return T(0.5 / d.at_start) * (dot(between, between) - length * length);
  }

 private:
  /// x_b(X) - x_a(X), written such that small motions keep their digits.
  Vector3<T> apart(const Vector3<double>& X) const { return b.displacement(X) - a.displacement(X); }
};

enum class Terms { all, linear };  ///< of the gradient in the motions: with its constant terms or without

/// The gradient of an equation of each kind. `direction`: what Turn compares with e, at the given value or its rates.
struct GradientOf {
  const BodyMotion<double>&a, &b;
  Vector3<double> direction;
  Terms terms;

  JointEquation::Forces operator()(const Coincidence& c) const {
    if (terms == Terms::linear) return {};
    return forces_at(c.point, c.point, c.normal);
  }
  JointEquation::Forces operator()(const Perpendicularity& p) const { return of_directions(p.a, p.b); }
  JointEquation::Forces operator()(const Travel& t) const {
    auto forces = forces_at(t.point, t.point, seen(a, t.normal));
    forces[0].add(1.0, {{}, outer(b.displacement(t.point) - a.displacement(t.point), t.normal)});
    return forces;
  }
  JointEquation::Forces operator()(const Turn& t) const { return of_directions(direction, t.e); }
  JointEquation::Forces operator()(const Distance& d) const {
    const Vector3<double> at_start = terms == Terms::all ? d.b - d.a : Vector3<double>{};
    const Vector3<double> between = at_start + b.displacement(d.b) - a.displacement(d.a);
    return forces_at(d.a, d.b, (1.0 / d.at_start) * between);
  }

 private:
  Vector3<double> seen(const BodyMotion<double>& body, const Vector3<double>& x) const {
    return terms == Terms::all ? body.direction(x) : body.turned(x);
  }
  /// The gradient of (F_a x) . (F_b y).
  JointEquation::Forces of_directions(const Vector3<double>& x, const Vector3<double>& y) const {
    return {MotionForce{{}, outer(seen(b, y), x)}, MotionForce{{}, outer(seen(a, x), y)}};
  }
  /// The gradient of f . (x_b(B) - x_a(A)), f constant.
  JointEquation::Forces forces_at(const Vector3<double>& A, const Vector3<double>& B, const Vector3<double>& f) const {
    return {MotionForce{-1.0 * f, outer(-1.0 * f, A - a.centre)}, MotionForce{f, outer(f, B - b.centre)}};
  }
};

/// cos(s) f - sin(s) e, as a function of time.
TimeSeries<Vector3<double>> direction_of(const Turn& t, const TimeSeries<double>& given) {
  const TimeSeries<double> c = cosine(given), s = sine(given);
  return {c.value * t.f - s.value * t.e, c.rate * t.f - s.rate * t.e, c.acceleration * t.f - s.acceleration * t.e};
}

}  // namespace

const Expression* JointEquation::given() const {
  if (const auto* travel = std::get_if<Travel>(&kind)) return travel->given ? &*travel->given : nullptr;
  if (const auto* turn = std::get_if<Turn>(&kind)) return &turn->given;
  if (const auto* distance = std::get_if<Distance>(&kind)) return distance->given ? &*distance->given : nullptr;
  return nullptr;
}

template <class T>
T JointEquation::operator()(const BodyMotion<T>& a, const BodyMotion<T>& b, const TimeSeries<double>& given) const {
  return std::visit(Evaluation<T>{a, b, given}, kind);
}

JointEquation::Forces JointEquation::gradient(const Motions& motions, const TimeSeries<double>& given) const {
  const auto* turn = std::get_if<Turn>(&kind);
  const Vector3<double> direction = turn != nullptr ? direction_of(*turn, given).value : Vector3<double>{};
  return std::visit(GradientOf{*motions[0], *motions[1], direction, Terms::all}, kind);
}

JointEquation::Forces JointEquation::change_of_gradient(const Motions& moves, const TimeSeries<double>& given) const {
  const auto* turn = std::get_if<Turn>(&kind);
  const Vector3<double> direction = turn != nullptr ? direction_of(*turn, given).value : Vector3<double>{};
  return std::visit(GradientOf{*moves[0], *moves[1], direction, Terms::linear}, kind);
}

JointEquation::Forces JointEquation::gradient_of_acceleration(const Motions& values, const Motions& once,
                                                              const Motions& twice,
                                                              const TimeSeries<double>& given) const {
  const auto* turn = std::get_if<Turn>(&kind);
  const auto direction = turn != nullptr ? direction_of(*turn, given) : TimeSeries<Vector3<double>>();
  const auto at = [&](const Motions& motions, const Vector3<double>& of_turn) {
    return std::visit(GradientOf{*motions[0], *motions[1], of_turn, Terms::all}, kind);
  };
  Forces forces = at(twice, direction.value);
  if (turn == nullptr) return forces;
  const Forces with_rate = at(once, direction.rate), with_acceleration = at(values, direction.acceleration);
  for (std::size_t side = 0; side < 2; ++side) {
    forces[side].add(2.0, with_rate[side]);
    forces[side].add(1.0, with_acceleration[side]);
  }
  return forces;
}

template double JointEquation::operator()(const BodyMotion<double>&, const BodyMotion<double>&,
                                          const TimeSeries<double>&) const;
template TimeSeries<double> JointEquation::operator()(const BodyMotion<TimeSeries<double>>&,
                                                      const BodyMotion<TimeSeries<double>>&,
                                                      const TimeSeries<double>&) const;
}  // namespace pliant
