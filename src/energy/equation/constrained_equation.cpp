#include "energy/equation/constrained_equation.hpp"

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
      diagonal_(equation.make_vector()),
      y0_(equation.make_vector()),
      w0_(equation.make_vector()),
      accepted_(equation.make_vector()) {
  if (!map.is_symmetric()) {
    check(MatMatMult(full_.get(), map.jacobian(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, product_.out()));
  }
  for (std::size_t i = 0; i < map.is_slave().size(); ++i) {
    prescribed_.push_back(equation.prescribed()[i] != 0 || map.is_slave()[i] != 0);
  }
}

StagePoint ConstrainedEquation::reduce(const StagePoint& stage, Vec q, Vec y) {
  stage_ = stage;
  map_.begin_stage(stage, q);
  map_.restrict(q, y);
  if (map_.is_linear()) return stage;
  check(VecWAXPY(y0_.get(), stage.dt, stage.v0, stage.q0));
  map_.restrict(y0_.get(), w0_.get());
  check(VecCopy(w0_.get(), y0_.get()));
  check(VecZeroEntries(w0_.get()));
  StagePoint reduced = stage;
  reduced.q0 = y0_.get();
  reduced.v0 = w0_.get();
  if (stage.accepted != nullptr) {
    map_.restrict(stage.accepted, accepted_.get());
    reduced.accepted = accepted_.get();
  }
  return reduced;
}

void ConstrainedEquation::begin_stage(const StagePoint& /*stage*/) {
  equation_.begin_stage(stage_);
}

double ConstrainedEquation::value(Vec y) {
  map_.expand(y, q_.get());
  return equation_.value(q_.get());
}

void ConstrainedEquation::gradient(Vec y, Vec r) {
  map_.expand(y, q_.get());
  equation_.gradient(q_.get(), full_gradient_.get());
  map_.linearize(y);
  check(MatMultTranspose(map_.test_matrix(), full_gradient_.get(), r));
}

Handle<Mat> ConstrainedEquation::make_hessian() const {
  Handle<Mat> K;
  if (map_.is_symmetric()) {
    check(MatPtAP(full_.get(), map_.jacobian(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, K.out()));
  } else {
    check(MatTransposeMatMult(map_.test_matrix(), product_.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, K.out()));
  }
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
    map_.restrict_rates(modes[m], mode.get());
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

std::unique_ptr<NodalRotations> ConstrainedEquation::make_rotations() const {
  auto rotations = equation_.make_rotations();
  if (rotations) rotations->hold(map_.is_tied());
  return rotations;
}

void ConstrainedEquation::freeze(Vec y) {
  map_.expand(y, q_.get());
  equation_.freeze(q_.get());
}

bool ConstrainedEquation::refreeze(Vec y) {
  map_.expand(y, q_.get());
  return equation_.refreeze(q_.get());
}

bool ConstrainedEquation::carry_along(Carried which, Vec y) {
  if (!equation_.carry_along(which, q_.get())) return false;
  map_.restrict(q_.get(), y);
  return true;
}

Vec ConstrainedEquation::displacements(Vec y) {
  map_.expand(y, q_.get());
  return q_.get();
}

void ConstrainedEquation::project(Mat K) {
  if (map_.is_symmetric()) {
    check(MatPtAP(full_.get(), map_.jacobian(), MAT_REUSE_MATRIX, PETSC_DEFAULT, &K));
    return;
  }
  Mat KJ = product_.get();
  check(MatMatMult(full_.get(), map_.jacobian(), MAT_REUSE_MATRIX, PETSC_DEFAULT, &KJ));
  check(MatTransposeMatMult(map_.test_matrix(), KJ, MAT_REUSE_MATRIX, PETSC_DEFAULT, &K));
}

void ConstrainedEquation::hessian(Vec y, Mat K, Projection projection) {
  map_.expand(y, q_.get());
  equation_.hessian(q_.get(), full_.get(), projection);
  map_.linearize(y);
  project(K);
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
  if (map_.is_linear() || projection != Projection::none) return;
  equation_.gradient(q_.get(), full_gradient_.get());
  map_.add_curvature(y, full_gradient_.get(), K);
}

std::vector<std::string> ConstrainedEquation::non_potentials() const {
  auto names = equation_.non_potentials();
  if (!map_.is_symmetric()) names.emplace_back("rigid parts that turn freely");
  return names;
}

Symmetry ConstrainedEquation::symmetry() const {
  return map_.is_symmetric() ? equation_.symmetry() : Symmetry::unsymmetric;
}

void ConstrainedEquation::rank_one_parts(Vec y, std::vector<RankOne>& parts) {
  map_.expand(y, q_.get());
  equation_.rank_one_parts(q_.get(), parts);
  map_.linearize(y);
  // Of W^T g (J^T g)^T the symmetric neighbour: where W is not J, it is as near as the rotation in a stage is small.
  for (const RankOne& part : parts) {
    check(VecCopy(part.g.get(), full_gradient_.get()));
    check(MatMultTranspose(map_.test_matrix(), full_gradient_.get(), part.g.get()));
  }
}

double ConstrainedEquation::max_step(Vec y, Vec d) {
  map_.expand(y, q_.get());
  map_.linearize(y);
  check(MatMult(map_.jacobian(), d, d_.get()));
  return equation_.max_step(q_.get(), d_.get());
}

void ConstrainedEquation::extrapolate_from(Vec y) {
  if (y != nullptr) map_.expand(y, q_.get());
  equation_.extrapolate_from(y != nullptr ? q_.get() : nullptr);
}

double ConstrainedEquation::max_way(Vec y, Vec d) {
  map_.expand(y, q_.get());
  map_.linearize(y);
  check(MatMult(map_.jacobian(), d, d_.get()));
  return equation_.max_way(q_.get(), d_.get());
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
