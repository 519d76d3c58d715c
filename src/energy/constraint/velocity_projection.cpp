#include "energy/constraint/velocity_projection.hpp"

#include "petsc/array_view.hpp"

#include <memory>
#include <utility>

namespace pliant {

VelocityProjection::VelocityProjection(const ConstrainedMass& bodies)
    : map_(bodies.map), mass_(make_matrix(bodies.layout, bodies.pattern)) {
  const NodeLayout& layout = bodies.layout;
  for (Handle<Vec>* x : {&difference_, &force_, &w_}) *x = make_vector(layout);
  const auto num_owned = static_cast<std::size_t>(3 * layout.num_owned_nodes);
  for (std::size_t i = 0; i < num_owned; ++i) {
    if (bodies.prescribed[i] || (map_ != nullptr && map_->is_slave()[i])) {
      excluded_.push_back(3 * layout.first_global_node + static_cast<PetscInt>(i));
    }
  }
  {
    BlockWriter writer(bodies.pattern, mass_.get());
    bodies.inertia.mass().assign_to(1.0, writer);
    writer.finish();
  }
  check(KSPCreate(layout.comm, ksp_.out()));
  check(KSPSetType(ksp_.get(), KSPCG));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCSetType(pc, PCJACOBI));
  // Solved to rounding: a mass matrix is well conditioned, and its solution a small part of the work of a step.
  constexpr double relative = 1e-14;
  constexpr PetscInt most_iterations = 500;
  check(KSPSetTolerances(ksp_.get(), relative, PETSC_DEFAULT, PETSC_DEFAULT, most_iterations));
}

// J^T M J; M itself if there is no map, with its excluded rows removed once.
Mat VelocityProjection::reduced_mass() {
  if (map_ == nullptr) {
    if (reduced_.get() == nullptr) check(MatDuplicate(mass_.get(), MAT_COPY_VALUES, reduced_.out()));
    return reduced_.get();
  }
  if (reduced_.get() == nullptr) {
    check(MatPtAP(mass_.get(), map_->jacobian(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, reduced_.out()));
    check(MatSetOption(reduced_.get(), MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
    return reduced_.get();
  }
  Mat reduced = reduced_.get();
  check(MatPtAP(mass_.get(), map_->jacobian(), MAT_REUSE_MATRIX, PETSC_DEFAULT, &reduced));
  return reduced;
}

void VelocityProjection::operator()(Vec q, Vec wanted, Vec v, Scope scope) {
  check(VecWAXPY(difference_.get(), -1.0, v, wanted));
  if (scope == Scope::dependents) map_->keep_free_motion_of_dependents(difference_.get());
  PetscReal size = 0.0;
  check(VecNorm(difference_.get(), NORM_INFINITY, &size));
  if (size == 0.0) return;
  if (map_ != nullptr) map_->linearize_at(q);
  const Mat reduced = reduced_mass();
  check(MatMult(mass_.get(), difference_.get(), force_.get()));
  if (map_ != nullptr) {
    check(MatMultTranspose(map_->jacobian(), force_.get(), difference_.get()));
  } else {
    check(VecCopy(force_.get(), difference_.get()));
  }
  check(VecZeroEntries(w_.get()));
  check(MatZeroRowsColumns(reduced, static_cast<PetscInt>(excluded_.size()), excluded_.data(), 1.0, w_.get(),
                           difference_.get()));
  check(KSPSetOperators(ksp_.get(), reduced, reduced));
  check(KSPSolve(ksp_.get(), difference_.get(), w_.get()));
  if (map_ != nullptr) {
    check(MatMultAdd(map_->jacobian(), w_.get(), v, v));
  } else {
    check(VecAXPY(v, 1.0, w_.get()));
  }
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
