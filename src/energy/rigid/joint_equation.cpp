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

template <class T>
Vector3<T> lift(const Vector3<double>& a) {
  return {T(a[0]), T(a[1]), T(a[2])};
}

/// The value of an equation of each kind.
template <class T>
struct Evaluation {
  const BodyMotion<T>&a, &b;
  const TimeSeries<double>& given;

  T operator()(const Coincidence& c) const { return dot(lift<T>(c.normal), apart(c.point)); }
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
  Vector3<T> apart(const Vector3<double>& X) const {
    return b.translation + matvec(b.gradient, lift<T>(X - b.centre)) - a.translation -
           matvec(a.gradient, lift<T>(X - a.centre));
  }
};

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

template double JointEquation::operator()(const BodyMotion<double>&, const BodyMotion<double>&,
                                          const TimeSeries<double>&) const;
template Dual<double> JointEquation::operator()(const BodyMotion<Dual<double>>&, const BodyMotion<Dual<double>>&,
                                                const TimeSeries<double>&) const;
template Dual<Dual<double>> JointEquation::operator()(const BodyMotion<Dual<Dual<double>>>&,
                                                      const BodyMotion<Dual<Dual<double>>>&,
                                                      const TimeSeries<double>&) const;
template TimeSeries<double> JointEquation::operator()(const BodyMotion<TimeSeries<double>>&,
                                                      const BodyMotion<TimeSeries<double>>&,
                                                      const TimeSeries<double>&) const;
template TimeSeries<Dual<double>> JointEquation::operator()(const BodyMotion<TimeSeries<Dual<double>>>&,
                                                            const BodyMotion<TimeSeries<Dual<double>>>&,
                                                            const TimeSeries<double>&) const;

}  // namespace pliant
