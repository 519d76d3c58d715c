// The potential that holds unknowns near a point: its derivatives, and which unknowns it holds.
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "solver/proximal.hpp"

#include <gtest/gtest.h>

namespace pliant::test_proximal {
namespace {

constexpr PetscInt num_held = 3, num_entries = 5;  // of each rank

Handle<Vec> vector_of(double scale) {
  Handle<Vec> x;
  check(VecCreateMPI(MPI_COMM_WORLD, num_entries, PETSC_DECIDE, x.out()));
  const ArrayView entries(x.get());
  for (PetscInt i = 0; i < num_entries; ++i) entries[i] = scale * (1.0 + static_cast<double>(i));
  return x;
}

TEST(Proximal, IsASpringOfTheFirstUnknowns) {
  Proximal proximal;
  const Handle<Vec> centre = vector_of(1.0), q = vector_of(3.0), r = vector_of(0.0);
  EXPECT_EQ(proximal.value(q.get()), 0.0);
  proximal.hold(centre.get(), num_held, 0.5);
  // |q - centre|^2 = 4 (1 + 4 + 9) on each rank.
  EXPECT_DOUBLE_EQ(proximal.value(q.get()), 0.25 * 56.0 * num_ranks(MPI_COMM_WORLD));
  proximal.add_gradient(q.get(), r.get());
  const ConstArrayView entries(r.get());
  for (PetscInt i = 0; i < num_entries; ++i) {
    EXPECT_DOUBLE_EQ(entries[i], i < num_held ? 0.5 * 2.0 * (1.0 + static_cast<double>(i)) : 0.0);
  }
}

TEST(Proximal, GradientIsTheDerivative) {
  Proximal proximal;
  const Handle<Vec> centre = vector_of(1.0), q = vector_of(2.0), d = vector_of(0.7), r = vector_of(0.0);
  proximal.hold(centre.get(), num_held, 3.0);
  proximal.add_gradient(q.get(), r.get());
  PetscScalar slope = 0.0;
  check(VecDot(r.get(), d.get(), &slope));
  check(VecAXPY(q.get(), 0.5, d.get()));
  const double after = proximal.value(q.get());
  check(VecAXPY(q.get(), -1.0, d.get()));
  EXPECT_NEAR(after - proximal.value(q.get()), slope, 1e-12 * after);  // exact of a parabola
}

TEST(Proximal, HessianIsTheWeightsUntilItIsReleased) {
  Proximal proximal;
  const Handle<Vec> q = vector_of(1.0), diagonal = vector_of(0.0);
  Handle<Mat> K;
  check(MatCreateAIJ(MPI_COMM_WORLD, num_entries, num_entries, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr,
                     K.out()));
  for (PetscInt i = 0; i < num_entries; ++i) {
    const PetscInt row = num_entries * rank(MPI_COMM_WORLD) + i;
    check(MatSetValue(K.get(), row, row, 1.0, INSERT_VALUES));
  }
  check(MatAssemblyBegin(K.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K.get(), MAT_FINAL_ASSEMBLY));
  proximal.hold(q.get(), num_held, 2.0);
  proximal.add_hessian(K.get());
  proximal.release();
  proximal.add_hessian(K.get());
  check(MatGetDiagonal(K.get(), diagonal.get()));
  const ConstArrayView entries(diagonal.get());
  for (PetscInt i = 0; i < num_entries; ++i) EXPECT_EQ(entries[i], i < num_held ? 3.0 : 1.0);
}

}  // namespace
}  // namespace pliant::test_proximal
