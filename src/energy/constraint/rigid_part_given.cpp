#include "energy/constraint/rigid_part.hpp"
#include "petsc/array_view.hpp"

// What is prescribed of the translation of a rigid part.

namespace pliant {

GivenKinematics RigidPart::given_at(const StagePoint& stage) const {
  const double passed = stage.time - stage.step_start;
  return {motion_, stage.time, passed > 0.0 ? passed : stage.dt, stage.load_factor,
          passed > 0.0 ? Side::before : Side::after};
}

void RigidPart::start_stage(const StagePoint& stage) const {
  if (rigidity_ != Rigidity::of_accelerations || free_components_.size() == 3) return;
  const double dt = stage.dt;
  const GivenKinematics given = given_at(stage);
  const Vector3<double> q0 = (*fit_)(*layout_, nodes_, stage.q0).translation;
  const Vector3<double> v0 = (*fit_)(*layout_, nodes_, stage.v0).translation;
  const ArrayView q(stage.q0), v(stage.v0);
  for (std::size_t i = 0; i < 3; ++i) {
    if (!motion_.gives(static_cast<int>(i))) continue;
    const Kinematics centre = given(static_cast<int>(i), motion_.rigid->centre);
    for (const PetscInt a : nodes_) {
      const PetscInt entry = 3 * a + static_cast<PetscInt>(i);
      q[entry] += centre.u - dt * centre.v - q0[i];
      v[entry] += centre.v - dt * centre.a - v0[i];
    }
  }
}

void RigidPart::set_prescribed_fraction(double fraction) {
  if (is_ideal()) return;
  given_translation_ = fraction * end_translation_ + (1.0 - fraction) * start_translation_;
  at_ = {};
}

}  // namespace pliant
