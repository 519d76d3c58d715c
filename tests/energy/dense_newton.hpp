/// Newton's method for small bodies, to the last digits: orders in time are measured with it.
#pragma once

#include "energy/equation/incremental_potential.hpp"
#include "petsc/array_view.hpp"

#include <cmath>
#include <eigen3/Eigen/LU>
#include <memory>
#include <vector>

namespace pliant::test {

/// With the whole matrix, on one rank; until the unknowns change by less than `tolerance` [m], or no longer by less.
inline StageSolve dense_newton(IncrementalPotential& potential, double tolerance = 1e-14) {
  return [&potential, tolerance, K = std::make_shared<Handle<Mat>>(potential.make_hessian()),
          r = std::make_shared<Handle<Vec>>(potential.make_vector())](const StagePoint& stage, Vec q) {
    const PetscInt n = potential.num_unknowns();
    std::vector<PetscInt> all(static_cast<std::size_t>(n));
    for (PetscInt i = 0; i < n; ++i) all[static_cast<std::size_t>(i)] = i;
    Eigen::MatrixXd A(n, n);
    potential.begin_stage(stage);
    double previous = HUGE_VAL;
    for (int iteration = 1; iteration <= 50; ++iteration) {
      potential.gradient(q, r->get());
      potential.hessian(q, K->get(), Projection::none);
      check(MatGetValues(K->get(), n, all.data(), n, all.data(), A.data()));  // symmetric: rows are columns
      const ArrayView x(q), residual(r->get());
      const Eigen::Map<Eigen::VectorXd> b(residual.span().data(), n);
      const Eigen::VectorXd d = A.partialPivLu().solve(b);
      Eigen::Map<Eigen::VectorXd>(x.span().data(), n) -= d;
      const double change = d.lpNorm<Eigen::Infinity>();
      if (change < tolerance || (change < 100.0 * tolerance && change >= previous)) return StageReport{};
      previous = change;
    }
    return StageReport{StageOutcome::retry, "no convergence", 50, 0};
  };
}

}  // namespace pliant::test
