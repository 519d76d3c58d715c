#include "energy/constraint/velocity_projection.hpp"

#include "petsc/array_view.hpp"
#include "petsc/callback.hpp"
#include "petsc/ghosted.hpp"

#include <limits>
#include <memory>
#include <utility>

namespace pliant {
namespace {

/// sum_i D_i J_ik^2 of each column k.
void diagonal_of_product(Mat J, Vec D, Vec result) {
  Handle<Mat> squares;
  check(MatDuplicate(J, MAT_COPY_VALUES, squares.out()));
  Mat parts[2] = {nullptr, nullptr};
  check(MatMPIAIJGetSeqAIJ(squares.get(), &parts[0], &parts[1], nullptr));
  for (const Mat part : parts) {
    MatInfo info;
    double* values = nullptr;
    check(MatGetInfo(part, MAT_LOCAL, &info));
    check(MatSeqAIJGetArray(part, &values));
    for (PetscInt k = 0; k < static_cast<PetscInt>(info.nz_used); ++k) values[k] *= values[k];
    check(MatSeqAIJRestoreArray(part, &values));
  }
  check(MatMultTranspose(squares.get(), D, result));
}

}  // namespace

VelocityProjection::VelocityProjection(const ConstrainedMass& bodies) : map_(bodies.map), mass_(bodies.inertia.mass()) {
  const NodeLayout& layout = bodies.layout;
  for (Handle<Vec>* x : {&expanded_, &force_, &w_, &rhs_, &diagonal_, &masses_}) *x = make_vector(layout);
  const auto num_owned = static_cast<std::size_t>(3 * layout.num_owned_nodes);
  is_excluded_.assign(num_owned, 0);
  for (std::size_t i = 0; i < num_owned; ++i) {
    if (bodies.prescribed[i] || (map_ != nullptr && map_->is_slave()[i])) is_excluded_[i] = 1;
  }
  {
    const ArrayView masses(masses_.get());
    mass_.put_diagonal(masses.span());
  }
  const auto size = static_cast<PetscInt>(num_owned);
  check(MatCreateShell(layout.comm, size, size, PETSC_DETERMINE, PETSC_DETERMINE, this, reduced_.out()));
  check(MatShellSetOperation(reduced_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  check(MatShellSetOperation(reduced_.get(), MATOP_GET_DIAGONAL, reinterpret_cast<void (*)()>(diagonal_callback)));
  check(KSPCreate(layout.comm, ksp_.out()));
  check(KSPSetType(ksp_.get(), KSPCG));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCSetType(pc, PCJACOBI));
}

void VelocityProjection::clear_excluded(Vec x) const {
  const ArrayView entries(x);
  for (std::size_t i = 0; i < is_excluded_.size(); ++i) {
    if (is_excluded_[i]) entries.span()[i] = 0.0;
  }
}

void VelocityProjection::put_force(Vec v, Vec f) {
  update_ghosts(v);
  check(VecZeroEntries(force_.get()));
  {
    const ConstGhostedView velocities(v);
    const GhostedView forces(force_.get());
    mass_.add_times(velocities.span(), forces.span());
  }
  map_ != nullptr ? check(MatMultTranspose(map_->jacobian(), force_.get(), f)) : check(VecCopy(force_.get(), f));
  clear_excluded(f);
}

// Entries that are excluded are zero in x and y.
void VelocityProjection::multiply(Vec x, Vec y) {
  map_ != nullptr ? check(MatMult(map_->jacobian(), x, expanded_.get())) : check(VecCopy(x, expanded_.get()));
  put_force(expanded_.get(), y);
}

void VelocityProjection::operator()(Vec q, Vec wanted, Vec v, Scope scope) {
  check(VecWAXPY(expanded_.get(), -1.0, v, wanted));
  if (scope == Scope::dependents) map_->keep_free_motion_of_dependents(expanded_.get());
  PetscReal size = 0.0, of_all = 0.0;
  check(VecNorm(expanded_.get(), NORM_INFINITY, &size));
  if (size == 0.0) return;
  if (map_ != nullptr) map_->linearize_at(q);
  put_force(expanded_.get(), rhs_.get());
  map_ != nullptr ? diagonal_of_product(map_->jacobian(), masses_.get(), diagonal_.get())
                  : check(VecCopy(masses_.get(), diagonal_.get()));
  {
    const ArrayView entries(diagonal_.get());
    for (std::size_t i = 0; i < is_excluded_.size(); ++i) {
      if (is_excluded_[i] || !(entries.span()[i] > 0.0)) entries.span()[i] = 1.0;
    }
  }
  // Solved to rounding: of the velocities, as residuals divided by the diagonal are.
  constexpr double relative = 1e-14;
  constexpr PetscInt most_iterations = 500;
  check(VecNorm(wanted, NORM_2, &of_all));
  check(KSPSetTolerances(ksp_.get(), relative, std::numeric_limits<double>::epsilon() * of_all, PETSC_DEFAULT,
                         most_iterations));
  check(KSPSetOperators(ksp_.get(), reduced_.get(), reduced_.get()));
  check(MatAssemblyBegin(reduced_.get(), MAT_FINAL_ASSEMBLY));  // with another diagonal
  check(MatAssemblyEnd(reduced_.get(), MAT_FINAL_ASSEMBLY));
  guard_.rethrow(KSPSolve(ksp_.get(), rhs_.get(), w_.get()));
  if (map_ != nullptr) {
    check(MatMultAdd(map_->jacobian(), w_.get(), v, v));
  } else {
    check(VecAXPY(v, 1.0, w_.get()));
  }
}

PetscErrorCode VelocityProjection::multiply_callback(Mat A, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  auto* projection = static_cast<VelocityProjection*>(self);
  return projection->guard_.run([&] { projection->multiply(x, y); });
}

PetscErrorCode VelocityProjection::diagonal_callback(Mat A, Vec diagonal) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  return VecCopy(static_cast<VelocityProjection*>(self)->diagonal_.get(), diagonal);
}

PrescribedMotion with_projected_velocities(PrescribedMotion motion, const ConstrainedMass& bodies) {
  using Scope = VelocityProjection::Scope;
  const auto wanted = std::make_shared<Handle<Vec>>(make_vector(bodies.layout));
  if (bodies.map != nullptr && !bodies.map->is_symmetric()) {
    const auto projection = std::make_shared<VelocityProjection>(bodies);
    motion.complete_step = [wanted, projection, complete = std::move(motion.complete_step)](const Step& step, Vec q,
                                                                                            Vec v) {
      check(VecCopy(v, wanted->get()));
      complete(step, q, v);
      (*projection)(q, wanted->get(), v, Scope::dependents);
    };
  }
  motion.restart = [wanted, bodies, restart = std::move(motion.restart)](const Step& step, Vec q, Vec v) {
    check(VecCopy(v, wanted->get()));
    restart(step, q, v);
    PetscBool is_the_same = PETSC_FALSE;
    check(VecEqual(v, wanted->get(), &is_the_same));
    // Restarts are rare: the matrices are not kept for them.
    if (is_the_same == PETSC_FALSE) VelocityProjection{bodies}(q, wanted->get(), v, Scope::all);
  };
  return motion;
}

}  // namespace pliant
