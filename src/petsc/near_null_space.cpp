#include "petsc/near_null_space.hpp"

namespace pliant {

// NOLINTNEXTLINE(performance-unnecessary-value-param): what the modes hold is changed
Handle<MatNullSpace> near_null_space(MPI_Comm comm, std::vector<Handle<Vec>> modes) {
  // Modified Gram-Schmidt; modes that nothing is left of are dropped.
  std::vector<Vec> kept;
  for (const Handle<Vec>& mode : modes) {
    Vec v = mode.get();
    PetscReal before = 0.0, after = 0.0;
    check(VecNorm(v, NORM_2, &before));
    for (Vec w : kept) {
      PetscScalar product = 0.0;
      check(VecDot(v, w, &product));
      check(VecAXPY(v, -product, w));
    }
    check(VecNorm(v, NORM_2, &after));
    if (after <= 1e-10 * before || before == 0.0) continue;
    check(VecScale(v, 1.0 / after));
    kept.push_back(v);
  }
  Handle<MatNullSpace> space;
  check(MatNullSpaceCreate(comm, PETSC_FALSE, static_cast<PetscInt>(kept.size()), kept.data(), space.out()));
  return space;
}

void set_near_null_modes(Mat K, std::vector<Handle<Vec>> modes) {
  const auto space = near_null_space(PetscObjectComm(reinterpret_cast<PetscObject>(K)), std::move(modes));
  check(MatSetNearNullSpace(K, space.get()));
}

}  // namespace pliant
