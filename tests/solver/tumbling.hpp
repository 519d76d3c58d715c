/// Rigid bodies in motion, and two solvers of their stages.
#pragma once

#include "energy/rigid/rigid_body.hpp"
#include "solver/newton.hpp"
#include "time/bodies.hpp"
#include "time/integrator.hpp"

#include <memory>
#include <utility>

namespace pliant::test {

/// Newton's method body by body with Gaussian elimination: for runs of very many steps. It converges quadratically: an
/// increment of 1e-9 leaves an error below rounding.
template <class Group>
StageReport solve_body_by_body(RigidBodies<Group>& equation, Mat K, const StagePoint& stage, Vec q) {
  constexpr auto n = static_cast<PetscInt>(Group::num_coordinates);
  equation.begin_stage(stage);
  const auto r = equation.make_vector();
  PetscInt first = 0, last = 0;
  check(MatGetOwnershipRange(K, &first, &last));
  StageReport report{StageOutcome::retry, "no convergence", 0, 0};
  for (double change = INFINITY; report.newton_iterations < 20; ++report.newton_iterations) {
    equation.gradient(q, r.get());
    if (maximum(equation.comm(), change) < 1e-9) {
      report.outcome = StageOutcome::converged;
      break;
    }
    equation.hessian(q, K, Projection::none);
    const ArrayView xi(q);
    const ConstArrayView residual(r.get());
    change = 0.0;
    for (PetscInt row = first; row < last; row += n) {
      std::array<std::array<double, n + 1>, n> A{};
      for (PetscInt i = 0; i < n; ++i) {
        for (PetscInt j = 0; j < n; ++j) {
          const PetscInt global_i = row + i, global_j = row + j;
          check(MatGetValues(K, 1, &global_i, 1, &global_j, &A[i][j]));
        }
        A[i][n] = residual[row - first + i];
      }
      for (PetscInt k = 0; k < n; ++k) {
        for (PetscInt i = k + 1; i < n; ++i) {
          if (std::abs(A[i][k]) > std::abs(A[k][k])) std::swap(A[i], A[k]);
        }
        for (PetscInt i = 0; i < n; ++i) {
          const double factor = i == k ? 0.0 : A[i][k] / A[k][k];
          for (PetscInt j = k; j <= n; ++j) A[i][j] -= factor * A[k][j];
        }
      }
      for (PetscInt i = 0; i < n; ++i) {
        xi[row - first + i] -= A[i][n] / A[i][i];
        change = std::max(change, std::abs(A[i][n] / A[i][i]));
      }
    }
  }
  return report;
}

enum class Solver { newton, body_by_body };

/// A run of bodies by a method.
template <class Group>
class Tumbling {
 public:
  using Configuration = std::array<double, Group::num_numbers>;
  using Velocity = std::array<double, Group::num_coordinates>;
  struct Body {
    RigidBody body;
    Configuration q;
    Velocity v;
  };

  /// This rank's bodies. Collective on `comm`.
  Tumbling(const Method& method, const std::vector<Body>& bodies, const Vector3<double>& gravity, Solver solver,
           MPI_Comm comm = MPI_COMM_WORLD)
      : equation_(comm, rigid_bodies(bodies), gravity), K_(equation_.make_hessian()) {
    const auto q = equation_.make_configuration(), v = equation_.make_vector();
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      put(q.get(), k, bodies[k].q);
      put(v.get(), k, bodies[k].v);
    }
    System system;
    system.space = std::make_shared<LieGroupSpace<Group>>();
    system.guess = Guess::extrapolated;
    if (solver == Solver::newton) {
      NewtonOptions options;
      options.relative = 1e-13;
      newton_ = std::make_unique<NewtonSolver>(equation_, options, LinearKind::cholesky);
      system.solve = [this](const StagePoint& stage, Vec x) { return newton_->solve(stage, x); };
    } else {
      system.solve = [this](const StagePoint& stage, Vec x) {
        return solve_body_by_body(equation_, K_.get(), stage, x);
      };
    }
    integrator_ = std::make_unique<Integrator>(IntegratorOptions{method, Startup::dirk33}, std::move(system),
                                               StateView{0.0, q.get(), v.get()});
  }

  void step(double dt) {
    const StepAttempt attempt = integrator_->attempt({++num_steps_ * dt, dt});
    ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << attempt.report.reason;
    integrator_->accept(attempt);
  }
  Configuration q(std::size_t k) const { return numbers_of<Group::num_numbers>(state().q.get(), k); }
  Velocity v(std::size_t k) const { return numbers_of<Group::num_coordinates>(state().v.get(), k); }
  const State& state() const { return integrator_->state(); }
  double energy() const { return equation_.energy(state().q.get(), state().v.get()); }

 private:
  static std::vector<RigidBody> rigid_bodies(const std::vector<Body>& bodies) {
    std::vector<RigidBody> result;
    for (const Body& body : bodies) result.push_back(body.body);
    return result;
  }

  RigidBodies<Group> equation_;
  Handle<Mat> K_;
  std::unique_ptr<NewtonSolver> newton_;
  std::unique_ptr<Integrator> integrator_;
  int num_steps_ = 0;
};

inline Tensor3<double> diagonal(const Vector3<double>& I) {
  return make_tensor([&](int i, int j) { return i == j ? I[static_cast<std::size_t>(i)] : 0.0; });
}

}  // namespace pliant::test
