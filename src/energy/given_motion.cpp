#include "energy/given_motion.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr int num_times = 7;
// Weights of f(t - k h), k = 0..6, for f'(t) h (sixth order) and f''(t) h^2 (fifth order): Fornberg 1988, table 3.
constexpr std::array<double, num_times> first_weights{49.0 / 20, -6.0,     15.0 / 2, -20.0 / 3,
                                                      15.0 / 4,  -6.0 / 5, 1.0 / 6};
constexpr std::array<double, num_times> second_weights{203.0 / 45, -87.0 / 5, 117.0 / 4,  -254.0 / 9,
                                                       33.0 / 2,   -27.0 / 5, 137.0 / 180};

/// One-sided differences from `time` to `end`.
template <class F>
Kinematics differentiated(F f, double time, double end) {
  const double h = (time - end) / (num_times - 1);
  Kinematics result{f(time), 0.0, 0.0};
  for (std::size_t k = 0; k < num_times; ++k) {
    // The last point is the end itself: rounding must not move it beyond.
    const double value = k == 0 ? result.u : f(k + 1 == num_times ? end : time - static_cast<double>(k) * h);
    result.v += first_weights[k] * value / h;
    result.a += second_weights[k] * value / (h * h);
  }
  return result;
}

bool is_finite(const TimeJet& jet) {
  return std::isfinite(jet.value) && std::isfinite(jet.rate) && std::isfinite(jet.acceleration);
}

}  // namespace

// (R - I) r = 2 w n x r + 2 n x (n x r) for the quaternion (w, n)
Vector3<double> Placement::displacement(const Vector3<double>& arm) const {
  const Vector3<double> n = {rotation[1], rotation[2], rotation[3]}, b = cross(n, arm);
  return translation + 2.0 * (rotation[0] * b + cross(n, b));
}

Placement RigidMotion::at(double time, double factor) const {
  Placement placement;
  for (std::size_t i = 0; i < 3; ++i) {
    if (translation[i]) placement.translation[i] = factor * (*translation[i])(0.0, 0.0, 0.0, time);
  }
  placement.rotation = exponential((factor * angle(0.0, 0.0, 0.0, time)) * axis);
  return placement;
}

bool RigidMotion::depends_on_time() const {
  return angle.depends_on_time() || std::ranges::any_of(translation, [](const std::optional<Expression>& component) {
           return component && component->depends_on_time();
         });
}

double GivenDisplacement::operator()(int component, const Vector3<double>& X, double time, double factor) const {
  const auto i = static_cast<std::size_t>(component);
  if (rigid) return rigid->at(time, factor).displacement(X - rigid->centre)[i];
  return factor * (*components[i])(X[0], X[1], X[2], time);
}

GivenKinematics::GivenKinematics(const GivenDisplacement& given, double time, double time_scale, double factor,
                                 Side side)
    : given_(given), time_(time), factor_(factor) {
  // Larger than the rounding of times, and far smaller than a step.
  constexpr double aside = 1e-6;
  const bool is_before = time > 0.0 && side == Side::before;
  end_ = is_before ? std::max(0.0, time - time_scale) : time + time_scale;
  side_ = time + aside * (end_ - time);
  const auto jet = [&](const Expression& formula) {
    TimeJet result = formula.derivatives(0.0, 0.0, 0.0, time_, side_);
    for (double* x : {&result.value, &result.rate, &result.acceleration}) *x *= factor_;
    return result;
  };
  if (given.rigid) {
    placement_ = given.rigid->at(time, factor);
    for (std::size_t i = 0; i < 3; ++i) {
      if (given.rigid->translation[i]) centre_[i] = jet(*given.rigid->translation[i]);
    }
    angle_ = jet(given.rigid->angle);
    // Where the motion jumps, on the side.
    for (std::size_t i = 0; i < 3; ++i) {
      if (is_finite(centre_[i])) placement_.translation[i] = centre_[i].value;
    }
    if (is_finite(angle_)) placement_.rotation = exponential(angle_.value * given.rigid->axis);
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& formula = given.components[i];
    if (formula && !formula->depends_on_space()) anywhere_[i] = of_formula(*formula, {});
  }
}

Kinematics GivenKinematics::of_formula(const Expression& formula, const Vector3<double>& X) const {
  const auto& [x, y, z] = X;
  if (!formula.depends_on_time()) return {factor_ * formula(x, y, z, time_), 0.0, 0.0};
  const TimeJet jet = formula.derivatives(x, y, z, time_, side_);
  if (is_finite(jet)) return {factor_ * jet.value, factor_ * jet.rate, factor_ * jet.acceleration};
  return differentiated([&, at_x = x, at_y = y, at_z = z](double t) { return factor_ * formula(at_x, at_y, at_z, t); },
                        time_, end_);
}

// u = d + (R - I) r, u' = d' + theta' n x R r, u'' = d'' + theta'' n x R r + theta'^2 n x (n x R r)
Kinematics GivenKinematics::of_rigid_body(std::size_t component, const Vector3<double>& arm) const {
  const RigidMotion& motion = *given_.rigid;
  const TimeJet& d = centre_[component];
  if (!is_finite(d) || !is_finite(angle_)) {
    return differentiated([&](double t) { return motion.at(t, factor_).displacement(arm)[component]; }, time_, end_);
  }
  const Vector3<double> r = turn(placement_.rotation, arm);
  const Vector3<double> across = cross(motion.axis, r), inward = cross(motion.axis, across);
  return {placement_.displacement(arm)[component], d.rate + angle_.rate * across[component],
          d.acceleration + angle_.acceleration * across[component] + angle_.rate * angle_.rate * inward[component]};
}

Kinematics GivenKinematics::operator()(int component, const Vector3<double>& X) const {
  const auto i = static_cast<std::size_t>(component);
  if (given_.rigid) return of_rigid_body(i, X - given_.rigid->centre);
  return anywhere_[i] ? *anywhere_[i] : of_formula(*given_.components[i], X);
}

}  // namespace pliant
