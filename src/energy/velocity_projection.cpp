#include "energy/velocity_projection.hpp"

#include "petsc/array_view.hpp"

#include <memory>
#include <utility>

namespace pliant {

VelocityProjection::VelocityProjection(const NodeLayout& layout, const BlockPattern& pattern, const Inertia& inertia,
                                       const std::vector<char>& prescribed, ConstraintMap& map)
    : map_(map), mass_(make_matrix(layout, pattern)) {
  for (Handle<Vec>* x : {&difference_, &force_, &w_}) *x = make_vector(layout);
  for (std::size_t i = 0; i < map.is_slave().size(); ++i) {
    if (prescribed[i] || map.is_slave()[i]) {
      excluded_.push_back(3 * layout.first_global_node + static_cast<PetscInt>(i));
    }
  }
  {
    BlockWriter writer(pattern, mass_.get());
    inertia.mass().assign_to(1.0, writer);
    writer.finish();
  }
  check(KSPCreate(layout.comm, ksp_.out()));
  check(KSPSetType(ksp_.get(), KSPCG));
  PC pc = nullptr;
  check(KSPGetPC(ksp_.get(), &pc));
  check(PCSetType(pc, PCJACOBI));
  // To rounding: a mass matrix is well conditioned, and its solution a small part of the work of a step.
  constexpr double relative = 1e-14;
  constexpr PetscInt most_iterations = 500;
  check(KSPSetTolerances(ksp_.get(), relative, PETSC_DEFAULT, PETSC_DEFAULT, most_iterations));
}

void VelocityProjection::operator()(Vec q, Vec wanted, Vec v) {
  map_.linearize_at(q);
  const MatReuse reuse = reduced_.get() == nullptr ? MAT_INITIAL_MATRIX : MAT_REUSE_MATRIX;
  Mat reduced = reduced_.get();
  if (reuse == MAT_INITIAL_MATRIX) {
    check(MatPtAP(mass_.get(), map_.jacobian(), reuse, PETSC_DEFAULT, reduced_.out()));
    reduced = reduced_.get();
    check(MatSetOption(reduced, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
  } else {
    check(MatPtAP(mass_.get(), map_.jacobian(), reuse, PETSC_DEFAULT, &reduced));
  }
  check(VecWAXPY(difference_.get(), -1.0, v, wanted));
  // What is given was put right, and is no concern of the neighbours.
  map_.keep_free_patches(difference_.get());
  check(MatMult(mass_.get(), difference_.get(), force_.get()));
  check(MatMultTranspose(map_.jacobian(), force_.get(), difference_.get()));
  check(VecZeroEntries(w_.get()));
  check(MatZeroRowsColumns(reduced, static_cast<PetscInt>(excluded_.size()), excluded_.data(), 1.0, w_.get(),
                           difference_.get()));
  check(KSPSetOperators(ksp_.get(), reduced, reduced));
  check(KSPSolve(ksp_.get(), difference_.get(), w_.get()));
  check(MatMultAdd(map_.jacobian(), w_.get(), v, v));
}

PrescribedMotion with_projected_velocities(PrescribedMotion motion, VelocityProjection projection,
                                           const NodeLayout& layout) {
  const auto shared = std::make_shared<VelocityProjection>(std::move(projection));
  const auto wanted = std::make_shared<Handle<Vec>>(make_vector(layout));
  motion.complete_step = [shared, wanted, complete = std::move(motion.complete_step)](const Step& step, Vec q, Vec v) {
    check(VecCopy(v, wanted->get()));
    complete(step, q, v);
    (*shared)(q, wanted->get(), v);
  };
  return motion;
}

}  // namespace pliant
