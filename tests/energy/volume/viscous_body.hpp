/// A body with a viscous term alone, in a motion that strains and turns it: what the tests of viscosity share.
#pragma once

#include "energy/solid.hpp"
#include "energy/volume/viscous.hpp"
#include "material/states.hpp"

#include <ostream>

namespace pliant::test {

inline constexpr double viscous_dt = 0.05;  ///< length of the stages [s]

struct ViscousCase {
  ViscosityVariant law;
  BodySpec body;
};

inline std::ostream& operator<<(std::ostream& out, const ViscousCase& c) {
  return out << name_of(c.law) << c.body;
}

inline std::vector<ViscousCase> every_viscous_case() {
  std::vector<ViscousCase> cases;
  for (const BodySpec body :
       {BodySpec{1, Shape::jittered, 2}, BodySpec{2, Shape::jittered, 2}, BodySpec{2, Shape::curved, 2}}) {
    for (const auto& law : every_viscosity()) cases.push_back({law, body});
  }
  return cases;
}

/// A body, its viscous term, and a potential of that term alone.
struct ViscousBody {
  ViscousBody(MPI_Comm on, const std::string& file, const ViscousCase& of)
      : solid(on, file, of.body.order, 2 * (of.body.order - 1)),
        term(solid.viscous(of.law)),
        potential(solid.layout(), solid.pattern(), {term.get()}, solid.nothing_prescribed()),
        maxwell(std::get_if<Maxwell>(&of.law)) {}

  Handle<Vec> gradient(const Handle<Vec>& q) {
    Handle<Vec> r = potential.make_vector();
    potential.gradient(q.get(), r.get());
    return r;
  }
  /// Power that the term's forces take from the motion (q - q0) / dt of the stage.
  double power(const TestStage& stage, const Handle<Vec>& q) {
    potential.begin_stage(stage.point);
    return dot(gradient(q).get(), moved(q.get(), -1.0, stage.q0.get()).get()) / stage.point.dt;
  }
  double dissipation(const TestStage& stage, const Handle<Vec>& q) const {
    const auto q0 = local_values(stage.q0.get()), v0 = local_values(stage.v0.get());
    const auto z0 = internal(stage.z0);
    return sum(solid.layout().comm,
               term->dissipation({stage.point.time, stage.point.dt, 1.0, q0, v0, z0}, local_values(q.get())));
  }
  double energy(const Handle<Vec>& q, const Handle<Vec>& z) const {
    return sum(solid.layout().comm, term->energy(local_values(q.get()), internal(z)));
  }
  /// Internal variables at the end of the stage.
  Handle<Vec> end_stage(const TestStage& stage, const Handle<Vec>& q) {
    Handle<Vec> z = potential.make_internal();
    if (z) potential.internal_variables().end_stage(stage.point, q.get(), z.get());
    return z;
  }
  /// A stage from `start`, where the body has been for ever: no force comes of staying there.
  TestStage stage_from(const Field& start, double length = viscous_dt) {
    TestStage stage(solid, 0.7, length, start);
    stage.z0 = potential.make_internal();
    if (!stage.z0) return stage;
    const Handle<Vec> zero = potential.make_internal();
    StagePoint for_ever = stage.point;
    for_ever.dt = 1e30;
    for_ever.z0 = zero.get();
    potential.internal_variables().end_stage(for_ever, stage.q0.get(), stage.z0.get());
    stage.point.z0 = stage.z0.get();
    return stage;
  }

  Solid solid;
  std::unique_ptr<EnergyTerm> term;
  IncrementalPotential potential;
  const Maxwell* maxwell;  ///< nullptr if the law is another

 private:
  static std::vector<double> internal(const Handle<Vec>& z) {
    if (!z) return {};
    const ConstArrayView view(z.get());
    return {view.span().begin(), view.span().end()};
  }
};

class EveryViscosity : public ::testing::TestWithParam<ViscousCase> {
 protected:
  Scratch scratch_{MPI_COMM_WORLD};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { write_body(f, GetParam().body); });
  ViscousBody body_{MPI_COMM_WORLD, file_, GetParam()};
  const Solid& solid_ = body_.solid;
  bool is_exact_ = !is_potential(GetParam().law);
};

/// Configurations along a motion that strains and turns the body.
inline Point moving(const Point& x, double t) {
  const Point u = strained(x), w = rough_field(0.05, 8)(x);
  const auto Q = testing_states::rotation(0.3 + 2.0 * t, -0.2, 1.0 + 3.0 * t);
  Point y{};
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) y[i] += Q(i, k) * (x[k] + u[k] * (1.0 + std::sin(4.0 * t)) + w[k] * t);
    y[i] -= x[i];
  }
  return y;
}
inline Field at_time(double t) {
  return [t](const Point& x) { return moving(x, t); };
}

/// The stage of length h that ends at time 0 of that motion; a branch is under stress from before.
inline TestStage stage_before_zero(ViscousBody& body, double h) {
  TestStage stage = body.stage_from(at_time(-h), h);
  if (body.maxwell != nullptr) {
    stage.z0 = body.stage_from(at_time(-1.0)).z0.share();
    stage.point.z0 = stage.z0.get();
  }
  return stage;
}

}  // namespace pliant::test
