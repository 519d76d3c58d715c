/// A space of configurations that is no vector space, as small as can be.
#pragma once

#include "petsc/array_view.hpp"
#include "time/ode.hpp"
#include "time/space.hpp"

#include <cmath>
#include <span>
#include <vector>

namespace pliant::test {

/// The circle, with coordinates that are no angles: retract((cos phi, sin phi), xi) turns phi by sinh(xi). The velocity
/// is phi', so that two numbers of configuration go with one of velocity, and xi' is not the velocity.
class Circle final : public ConfigurationSpace {
 public:
  static double angle(std::span<const double> q, std::size_t k) { return std::atan2(q[2 * k + 1], q[2 * k]); }

  void difference(Vec a, Vec b, Vec xi) const override {
    const ConstArrayView from(a), to(b);
    const ArrayView values(xi);
    for (std::size_t k = 0; k < values.span().size(); ++k) {
      values.span()[k] = std::asinh(std::remainder(angle(to, k) - angle(from, k), 2 * M_PI));
    }
  }
  void retract(Vec a, Vec xi, Vec b) const override {
    const ConstArrayView from(a), by(xi);
    const ArrayView to(b);
    for (std::size_t k = 0; k < by.span().size(); ++k) {
      const double phi = angle(from, k) + std::sinh(by.span()[k]);
      to.span()[2 * k] = std::cos(phi);
      to.span()[2 * k + 1] = std::sin(phi);
    }
  }
  void velocity(Vec xi, Vec xi_dot, Vec v) const override {
    const ConstArrayView by(xi), rate(xi_dot);
    const ArrayView values(v);
    for (std::size_t k = 0; k < by.span().size(); ++k) {
      values.span()[k] = std::cosh(by.span()[k]) * rate.span()[k];
    }
  }
};

inline Handle<Vec> points_of(const std::vector<double>& angles) {
  std::vector<double> points;
  for (double phi : angles) points.insert(points.end(), {std::cos(phi), std::sin(phi)});
  return vector_of(points);
}

/// The equation of `ode`, whose unknown is an angle, in coordinates around stage.centre; Newton's method, to rounding.
inline StageSolve solve_on_circle(const Ode& ode) {
  return [ode](const StagePoint& stage, Vec xi_vec) {
    const ConstArrayView centre(stage.centre), xi0(stage.q0), v0(stage.v0);
    const ArrayView xi(xi_vec);
    std::vector<double> phi(xi.span().size()), v(phi.size());
    for (std::size_t k = 0; k < phi.size(); ++k) {
      const auto residual = [&](double x) {
        phi[k] = Circle::angle(centre, k) + std::sinh(x);
        v[k] = std::cosh(x) * (x - xi0.span()[k]) / stage.dt;
        return (v[k] - v0.span()[k]) / stage.dt - ode.acceleration(stage.time, phi, v, k);
      };
      double& x = xi.span()[k];
      double change = INFINITY;
      for (int i = 0; i < 50 && std::abs(change) > 1e-15; ++i) {
        change = -residual(x) / (residual(x + 1e-5) - residual(x - 1e-5)) * 2e-5;
        x += change;
      }
    }
    return StageReport{};
  };
}

}  // namespace pliant::test
