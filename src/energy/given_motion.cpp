#include "energy/given_motion.hpp"

#include <algorithm>

namespace pliant {
namespace {

// Weights of f(t - k h), k = 0..6, for f'(t) h (sixth order) and f''(t) h^2 (fifth order): Fornberg 1988, table 3.
constexpr std::array<double, 7> first_weights{49.0 / 20, -6.0, 15.0 / 2, -20.0 / 3, 15.0 / 4, -6.0 / 5, 1.0 / 6};
constexpr std::array<double, 7> second_weights{203.0 / 45, -87.0 / 5, 117.0 / 4,  -254.0 / 9,
                                               33.0 / 2,   -27.0 / 5, 137.0 / 180};

/// From the values at t - k h.
Kinematics differentiated(const std::array<double, 7>& f, double h) {
  Kinematics result{f[0], 0.0, 0.0};
  for (std::size_t k = 0; k < f.size(); ++k) {
    result.v += first_weights[k] * f[k] / h;
    result.a += second_weights[k] * f[k] / (h * h);
  }
  return result;
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

GivenKinematics::GivenKinematics(const GivenDisplacement& given, double time, double time_scale, double factor)
    : given_(given), factor_(factor) {
  // Backward from t, not beyond the start of the run; at the start itself forward, which is a negative h. The last
  // point is the end of the range itself: rounding must not carry it across.
  const double end = time > 0.0 ? std::max(0.0, time - time_scale) : time_scale;
  h_ = (time - end) / (num_times - 1);
  for (int k = 1; k < num_times - 1; ++k) times_[k] = time - k * h_;
  times_.front() = time;
  times_.back() = end;
  if (given.rigid) {
    std::ranges::transform(times_, placements_.begin(), [&](double t) { return given.rigid->at(t, factor); });
    return;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& formula = given.components[i];
    if (formula && !formula->depends_on_space()) anywhere_[i] = of_formula(*formula, {});
  }
}

Kinematics GivenKinematics::of_formula(const Expression& formula, const Vector3<double>& X) const {
  const auto& [x, y, z] = X;
  if (!formula.depends_on_time()) return {factor_ * formula(x, y, z, times_[0]), 0.0, 0.0};
  std::array<double, num_times> f{};
  std::ranges::transform(times_, f.begin(), [&](double t) { return factor_ * formula(x, y, z, t); });
  return differentiated(f, h_);
}

Kinematics GivenKinematics::operator()(int component, const Vector3<double>& X) const {
  const auto i = static_cast<std::size_t>(component);
  if (!given_.rigid) return anywhere_[i] ? *anywhere_[i] : of_formula(*given_.components[i], X);
  const Vector3<double> arm = X - given_.rigid->centre;
  if (!given_.rigid->depends_on_time()) return {placements_[0].displacement(arm)[i], 0.0, 0.0};
  std::array<double, num_times> f{};
  std::ranges::transform(placements_, f.begin(), [&](const Placement& p) { return p.displacement(arm)[i]; });
  return differentiated(f, h_);
}

}  // namespace pliant
