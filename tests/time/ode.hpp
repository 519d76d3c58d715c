/// Equations small enough to solve by hand, spread over the ranks as vectors are.
#pragma once

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/handle.hpp"
#include "petsc/session.hpp"
#include "time/stepper.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

namespace pliant::test {

/// q'' = acceleration(t, q, v) of the owned entry k. May depend on other entries only if those are prescribed.
using Acceleration =
    std::function<double(double t, std::span<const double> q, std::span<const double> v, std::size_t k)>;

/// Values of the owned entries.
struct Values {
  std::vector<double> q, v;
};

/// A motion: equation, start, and the entries given in advance (every other one, or none).
struct Ode {
  Acceleration acceleration;
  Values initial;  // at t = 0
  /// (q_D, v_D, a_D) at t of the entries with even index; empty if none is prescribed.
  std::function<std::array<double, 3>(double t)> prescribed;

  bool is_prescribed(std::size_t k) const { return prescribed && k % 2 == 0; }
};

inline Handle<Vec> vector_of(const std::vector<double>& values) {
  Handle<Vec> x;
  check(VecCreateMPI(MPI_COMM_WORLD, static_cast<PetscInt>(values.size()), PETSC_DECIDE, x.out()));
  ArrayView array(x.get());
  for (std::size_t k = 0; k < values.size(); ++k) array[static_cast<PetscInt>(k)] = values[k];
  return x;
}

inline std::vector<double> values_of(Vec x) {
  const ConstArrayView array(x);
  return {array.span().begin(), array.span().end()};
}

/// Solves (v - v0)/dt = acceleration(t, q, v), v = (q - q0)/dt, entry by entry with Newton's method, to rounding.
inline StageSolve newton(const Ode& ode) {
  return [ode, v = std::vector<double>()](const StagePoint& stage, Vec q_vec) mutable {
    const ConstArrayView q0(stage.q0), v0(stage.v0);
    ArrayView q(q_vec);
    const std::span<double> q_span = q;
    v.resize(q_span.size());
    for (std::size_t k = 0; k < v.size(); ++k) v[k] = (q_span[k] - q0.span()[k]) / stage.dt;
    StageReport report;
    for (std::size_t k = 0; k < v.size(); ++k) {
      if (ode.is_prescribed(k)) continue;
      const auto residual = [&](double q_k) {
        q_span[k] = q_k;
        v[k] = (q_k - q0.span()[k]) / stage.dt;
        return (v[k] - v0.span()[k]) / stage.dt - ode.acceleration(stage.time, q_span, v, k);
      };
      double q_k = q_span[k], change = INFINITY;
      for (int i = 0; i < 30 && std::abs(change) > 1e-14 * (1.0 + std::abs(q_k)); ++i) {
        const double h = 1e-5 * (1.0 + std::abs(q_k));
        const double slope = (residual(q_k + h) - residual(q_k - h)) / (2 * h);
        change = -residual(q_k) / slope;
        q_k += change;
        report.newton_iterations = std::max(report.newton_iterations, i + 1);
      }
      residual(q_k);
      if (std::abs(change) > 1e-12 * (1.0 + std::abs(q_k)))
        return StageReport{StageOutcome::retry, "no convergence", 30, 0};
    }
    return report;
  };
}

/// The prescribed entries as the contract of PrescribedMotion wants them.
inline PrescribedMotion motion_of(const Ode& ode) {
  if (!ode.prescribed) return {};
  PrescribedMotion motion;
  motion.start_stage = [ode](const StagePoint& stage, Vec q_vec) {
    const auto [q_D, v_D, a_D] = ode.prescribed(stage.time);
    const ArrayView q0(stage.q0), v0(stage.v0), q(q_vec);
    for (PetscInt k = 0; k < static_cast<PetscInt>(ode.initial.q.size()); k += 2) {
      q0[k] = q_D - stage.dt * v_D;
      v0[k] = v_D - stage.dt * a_D;
      q[k] = q_D;
    }
  };
  motion.complete_step = [ode](const Step& step, Vec q_vec, Vec v_vec) {
    const auto [q_D, v_D, a_D] = ode.prescribed(step.time);
    const ArrayView q(q_vec), v(v_vec);
    for (PetscInt k = 0; k < static_cast<PetscInt>(ode.initial.q.size()); k += 2) {
      q[k] = q_D;
      v[k] = v_D;
    }
  };
  return motion;
}

inline System system_of(const Ode& ode, Guess guess = Guess::extrapolated) {
  return {.solve = newton(ode), .motion = motion_of(ode), .guess = guess};
}

inline Stepper make_stepper(const Method& method, const Ode& ode, Guess guess = Guess::extrapolated) {
  const Handle<Vec> layout = vector_of(ode.initial.q);
  return {method, system_of(ode, guess), {0.0, layout.get(), layout.get()}};
}

/// The motion at time t by the classical Runge-Kutta method; with 2000 steps per unit of time its error is below 1e-13
/// for accelerations of size one.
inline Values reference(const Ode& ode, double t) {
  const int num_steps = std::max(1, static_cast<int>(std::ceil(std::abs(t) * 2000)));
  const double h = t / num_steps;
  const std::size_t n = ode.initial.q.size();
  Values y = ode.initial;
  std::array<Values, 4> slope;
  for (int i = 0; i < num_steps; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double part = j == 0 ? 0.0 : (j == 3 ? h : h / 2), time = i * h + part;
      Values at = y;
      for (std::size_t k = 0; k < n; ++k) {
        if (j > 0) at.q[k] += part * slope[j - 1].q[k];
        if (j > 0) at.v[k] += part * slope[j - 1].v[k];
        if (ode.is_prescribed(k)) at.q[k] = ode.prescribed(time)[0], at.v[k] = ode.prescribed(time)[1];
      }
      slope[j] = at;
      for (std::size_t k = 0; k < n; ++k) {
        slope[j].q[k] = at.v[k];
        slope[j].v[k] = ode.is_prescribed(k) ? 0.0 : ode.acceleration(time, at.q, at.v, k);
      }
    }
    for (std::size_t k = 0; k < n; ++k) {
      y.q[k] += h / 6 * (slope[0].q[k] + 2 * slope[1].q[k] + 2 * slope[2].q[k] + slope[3].q[k]);
      y.v[k] += h / 6 * (slope[0].v[k] + 2 * slope[1].v[k] + 2 * slope[2].v[k] + slope[3].v[k]);
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (ode.is_prescribed(k)) y.q[k] = ode.prescribed(t)[0], y.v[k] = ode.prescribed(t)[1];
  }
  return y;
}

/// A history at t = 0 of the initial state alone, or preceded by states of the reference motion at the times given (<
/// 0, rising).
inline History history_of(const Ode& ode, const std::vector<double>& earlier = {}) {
  const auto depth = static_cast<int>(earlier.size()) + 1;
  std::vector<double> times = earlier;
  times.push_back(0.0);
  const auto state = [&](double t) { return t == 0.0 ? ode.initial : reference(ode, t); };
  const Values oldest = state(times[0]);
  History history(std::max(depth, 3), {times[0], vector_of(oldest.q).get(), vector_of(oldest.v).get()});
  for (std::size_t i = 1; i < times.size(); ++i) {
    const Values y = state(times[i]);
    history.push({times[i], vector_of(y.q).get(), vector_of(y.v).get()});
  }
  return history;
}

/// Largest difference over all ranks.
inline double largest_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return maximum(MPI_COMM_WORLD, largest);
}

/// A pendulum per entry, damped and driven; entries differ.
inline Ode pendulum() {
  const double w = 1.0 + 0.1 * pliant::rank(MPI_COMM_WORLD);
  return {[=](double t, auto q, auto v, std::size_t k) {
            const double f = w + 0.3 * static_cast<double>(k);
            return -f * std::sin(q[k]) - 0.2 * v[k] - 0.1 * v[k] * v[k] * v[k] + 0.5 * std::cos(1.3 * t);
          },
          {{1.0, -0.5}, {0.3, 0.8}},
          {}};
}

}  // namespace pliant::test
