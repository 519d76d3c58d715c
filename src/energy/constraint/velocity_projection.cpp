#include "energy/constraint/velocity_projection.hpp"

#include "energy/constraint/part_velocity_projection.hpp"

#include <limits>
#include <memory>
#include <utility>

namespace pliant {
namespace {

/// Per owned entry, whether it is not an unknown.
std::vector<char> entries_without_unknown(const ConstrainedMass& bodies) {
  std::vector<char> result(bodies.prescribed.begin(), bodies.prescribed.begin() + 3 * bodies.layout.num_owned_nodes);
  for (std::size_t i = 0; bodies.map != nullptr && i < result.size(); ++i) {
    if (bodies.map->is_slave()[i]) result[i] = 1;
  }
  return result;
}

}  // namespace

VelocityProjection::VelocityProjection(const ConstrainedMass& bodies)
    : map_(bodies.map),
      mass_(bodies, entries_without_unknown(bodies)),
      difference_(make_vector(bodies.layout)),
      rhs_(make_vector(bodies.layout)),
      w_(make_vector(bodies.layout)) {}

void VelocityProjection::operator()(Vec q, Vec wanted, Vec v, Scope scope) {
  check(VecWAXPY(difference_.get(), -1.0, v, wanted));
  if (scope == Scope::dependents) map_->keep_free_motion_of_dependents(difference_.get());
  PetscReal size = 0.0, of_all = 0.0;
  check(VecNorm(difference_.get(), NORM_INFINITY, &size));
  if (size == 0.0) return;
  if (map_ != nullptr) map_->linearize_at(q);
  mass_.multiply(difference_.get(), difference_.get());
  mass_.reduce(difference_.get(), rhs_.get());
  // Solved to rounding: of the velocities, as residuals divided by the diagonal are.
  constexpr double relative = 1e-14;
  check(VecNorm(wanted, NORM_2, &of_all));
  mass_.solve(rhs_.get(), w_.get(), relative, std::numeric_limits<double>::epsilon() * of_all);
  mass_.expand(w_.get(), difference_.get());
  check(VecAXPY(v, 1.0, difference_.get()));
}

PrescribedMotion with_projected_velocities(PrescribedMotion motion, const ConstrainedMass& bodies,
                                           EndVelocities end_velocities) {
  using Scope = VelocityProjection::Scope;
  const auto wanted = std::make_shared<Handle<Vec>>(make_vector(bodies.layout));
  const bool has_free_parts = bodies.map != nullptr && !bodies.map->is_symmetric();
  if (has_free_parts && end_velocities == EndVelocities::of_method && !bodies.map->is_driven()) {
    motion.complete_step = [wanted, map = bodies.map, complete = std::move(motion.complete_step)](const Step& step,
                                                                                                  Vec q, Vec v) {
      check(VecCopy(v, wanted->get()));
      complete(step, q, v);
      check(VecAXPY(wanted->get(), -1.0, v));
      map->keep_free_motion_of_dependents(wanted->get());
      check(VecAXPY(v, 1.0, wanted->get()));
    };
  } else if (has_free_parts) {
    const std::shared_ptr<PartVelocityProjection> of_parts = PartVelocityProjection::make(bodies);
    const auto of_all = of_parts == nullptr ? std::make_shared<VelocityProjection>(bodies) : nullptr;
    motion.complete_step = [wanted, of_parts, of_all, complete = std::move(motion.complete_step)](const Step& step,
                                                                                                  Vec q, Vec v) {
      check(VecCopy(v, wanted->get()));
      complete(step, q, v);
      of_parts != nullptr ? (*of_parts)(q, wanted->get(), v) : (*of_all)(q, wanted->get(), v, Scope::dependents);
    };
    motion.project_error = [wanted, of_parts, of_all, map = bodies.map](Vec q, Vec e) {
      check(VecCopy(e, wanted->get()));
      map->clear_dependents(e);
      of_parts != nullptr ? (*of_parts)(q, wanted->get(), e) : (*of_all)(q, wanted->get(), e, Scope::dependents);
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
