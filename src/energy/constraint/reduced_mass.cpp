#include "energy/constraint/reduced_mass.hpp"

#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

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

ReducedMass::ReducedMass(const ConstrainedMass& bodies, std::vector<char> is_excluded)
    : map_(bodies.map), mass_(bodies.inertia.mass()), is_excluded_(std::move(is_excluded)) {
  const NodeLayout& layout = bodies.layout;
  for (Handle<Vec>* x : {&expanded_, &force_, &ghosted_, &diagonal_, &masses_}) *x = make_vector(layout);
  {
    const ArrayView masses(masses_.get());
    mass_.put_diagonal(masses.span());
  }
  const PetscInt size = 3 * layout.num_owned_nodes;
  check(MatCreateShell(layout.comm, size, size, PETSC_DETERMINE, PETSC_DETERMINE, this, operator_.out()));
  check(MatShellSetOperation(operator_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  check(MatShellSetOperation(operator_.get(), MATOP_GET_DIAGONAL, reinterpret_cast<void (*)()>(diagonal_callback)));
  check(KSPCreate(layout.comm, ksp_.out()));
  check(KSPSetType(ksp_.get(), KSPCG));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCSetType(pc, PCJACOBI));
}

void ReducedMass::multiply(Vec v, Vec f) {
  check(VecCopy(v, ghosted_.get()));
  update_ghosts(ghosted_.get());
  check(VecZeroEntries(force_.get()));
  {
    const ConstGhostedView velocities(ghosted_.get());
    const GhostedView forces(force_.get());
    mass_.add_times(velocities.span(), forces.span());
  }
  check(VecCopy(force_.get(), f));
}

void ReducedMass::reduce(Vec f, Vec g) const {
  map_ != nullptr ? check(MatMultTranspose(map_->jacobian(), f, g)) : check(VecCopy(f, g));
  const ArrayView entries(g);
  for (std::size_t i = 0; i < is_excluded_.size(); ++i) {
    if (is_excluded_[i]) entries.span()[i] = 0.0;
  }
}

void ReducedMass::expand(Vec w, Vec v) const {
  map_ != nullptr ? check(MatMult(map_->jacobian(), w, v)) : check(VecCopy(w, v));
}

void ReducedMass::apply(Vec x, Vec y) {
  expand(x, expanded_.get());
  multiply(expanded_.get(), expanded_.get());
  reduce(expanded_.get(), y);
}

void ReducedMass::solve(Vec b, Vec w, double relative, double absolute) {
  constexpr PetscInt most_iterations = 500;
  map_ != nullptr ? diagonal_of_product(map_->jacobian(), masses_.get(), diagonal_.get())
                  : check(VecCopy(masses_.get(), diagonal_.get()));
  {
    const ArrayView entries(diagonal_.get());
    for (std::size_t i = 0; i < is_excluded_.size(); ++i) {
      if (is_excluded_[i] || !(entries.span()[i] > 0.0)) entries.span()[i] = 1.0;
    }
  }
  check(KSPSetTolerances(ksp_.get(), relative, absolute, PETSC_DEFAULT, most_iterations));
  check(KSPSetOperators(ksp_.get(), operator_.get(), operator_.get()));
  check(MatAssemblyBegin(operator_.get(), MAT_FINAL_ASSEMBLY));  // with another diagonal
  check(MatAssemblyEnd(operator_.get(), MAT_FINAL_ASSEMBLY));
  guard_.rethrow(KSPSolve(ksp_.get(), b, w));
}

PetscErrorCode ReducedMass::multiply_callback(Mat A, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  auto* mass = static_cast<ReducedMass*>(self);
  return mass->guard_.run([&] { mass->apply(x, y); });
}

PetscErrorCode ReducedMass::diagonal_callback(Mat A, Vec diagonal) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  return VecCopy(static_cast<ReducedMass*>(self)->diagonal_.get(), diagonal);
}

}  // namespace pliant
