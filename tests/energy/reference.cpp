#include "energy/reference.hpp"

#include <eigen3/Eigen/Eigenvalues>

namespace pliant::test {

std::array<double, 2> extreme_eigenvalues(IncrementalPotential& potential, Vec q, Projection projection) {
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q, K.get(), projection);
  const PetscInt n = potential.num_unknowns();
  Eigen::MatrixXd A(n, n);
  std::vector<PetscInt> all(static_cast<std::size_t>(n));
  for (PetscInt i = 0; i < n; ++i) all[i] = i;
  check(MatGetValues(K.get(), n, all.data(), n, all.data(), A.data()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A, Eigen::EigenvaluesOnly);
  return {solver.eigenvalues()(0), solver.eigenvalues()(n - 1)};
}

}  // namespace pliant::test
