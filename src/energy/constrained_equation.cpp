#include "energy/constrained_equation.hpp"

#include "petsc/array_view.hpp"

#include <cmath>

namespace pliant {

ConstrainedEquation::ConstrainedEquation(StageEquation& equation, ConstraintMap& map)
    : equation_(equation),
      map_(map),
      full_(equation.make_hessian()),
      q_(equation.make_vector()),
      d_(equation.make_vector()),
      full_gradient_(equation.make_vector()),
      diagonal_(equation.make_vector()) {
  for (std::size_t i = 0; i < map.is_slave().size(); ++i) {
    prescribed_.push_back(equation.prescribed()[i] != 0 || map.is_slave()[i] != 0);
  }
}

void ConstrainedEquation::begin_stage(const StagePoint& stage) {
  map_.set_time(stage.time, stage.load_factor);
  equation_.begin_stage(stage);
}

double ConstrainedEquation::value(Vec y) {
  map_.expand(y, q_.get());
  return equation_.value(q_.get());
}

void ConstrainedEquation::gradient(Vec y, Vec r) {
  map_.expand(y, q_.get());
  equation_.gradient(q_.get(), full_gradient_.get());
  check(MatMultTranspose(map_.matrix(), full_gradient_.get(), r));
}

Handle<Mat> ConstrainedEquation::make_hessian() const {
  Handle<Mat> K;
  check(MatPtAP(full_.get(), map_.matrix(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, K.out()));
  const PetscBool is_symmetric = symmetry() == Symmetry::symmetric ? PETSC_TRUE : PETSC_FALSE;
  check(MatSetOption(K.get(), MAT_SYMMETRIC, is_symmetric));
  check(MatSetOption(K.get(), MAT_SYMMETRY_ETERNAL, is_symmetric));
  check(MatSetOption(K.get(), MAT_STRUCTURALLY_SYMMETRIC, PETSC_TRUE));
  set_near_null_space(K.get());
  return K;
}

// Modes of the body as the unknowns see them. What slaves do in them follows; a mode that the constraints forbid is one
// of low energy still.
void ConstrainedEquation::set_near_null_space(Mat K) const {
  MatNullSpace space = nullptr;
  check(MatGetNearNullSpace(full_.get(), &space));
  if (space == nullptr) return;
  PetscInt num_modes = 0;
  const Vec* modes = nullptr;
  check(MatNullSpaceGetVecs(space, nullptr, &num_modes, &modes));
  std::vector<Handle<Vec>> reduced;
  for (PetscInt m = 0; m < num_modes; ++m) {
    Handle<Vec> mode;
    check(VecDuplicate(modes[m], mode.out()));
    check(VecCopy(modes[m], mode.get()));
    {
      const ArrayView entries(mode.get());
      for (std::size_t i = 0; i < map_.is_slave().size(); ++i) {
        if (map_.is_slave()[i]) entries[static_cast<PetscInt>(i)] = 0.0;
      }
    }
    reduced.push_back(std::move(mode));
  }
  set_near_null_modes(K, std::move(reduced));
}

void ConstrainedEquation::hessian(Vec y, Mat K, Projection projection) {
  map_.expand(y, q_.get());
  equation_.hessian(q_.get(), full_.get(), projection);
  check(MatPtAP(full_.get(), map_.matrix(), MAT_REUSE_MATRIX, PETSC_DEFAULT, &K));
  check(MatGetDiagonal(K, diagonal_.get()));
  PetscReal total = 0.0;
  check(VecNorm(diagonal_.get(), NORM_1, &total));
  const double mean = total > 0.0 ? total / num_unknowns() : 1.0;
  PetscInt first = 0;
  check(MatGetOwnershipRange(K, &first, nullptr));
  for (std::size_t i = 0; i < map_.is_slave().size(); ++i) {
    const PetscInt entry = first + static_cast<PetscInt>(i);
    if (map_.is_slave()[i]) check(MatSetValue(K, entry, entry, mean, INSERT_VALUES));
  }
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

void ConstrainedEquation::rank_one_parts(Vec y, std::vector<RankOne>& parts) {
  map_.expand(y, q_.get());
  equation_.rank_one_parts(q_.get(), parts);
  for (const RankOne& part : parts) {
    check(VecCopy(part.g.get(), full_gradient_.get()));
    check(MatMultTranspose(map_.matrix(), full_gradient_.get(), part.g.get()));
  }
}

double ConstrainedEquation::max_step(Vec y, Vec d) {
  map_.expand(y, q_.get());
  check(MatMult(map_.matrix(), d, d_.get()));
  return equation_.max_step(q_.get(), d_.get());
}

double ConstrainedEquation::force_scale(Vec y) {
  map_.expand(y, q_.get());
  return equation_.force_scale(q_.get());
}

double ConstrainedEquation::rounding_floor(Vec y) const {
  map_.expand(y, q_.get());
  return equation_.rounding_floor(q_.get());
}

}  // namespace pliant
