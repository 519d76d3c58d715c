// What viscosity must do beyond having the right derivatives; those of the form without a potential too.
#include "energy/reference.hpp"
#include "energy/volume/viscous_body.hpp"

namespace pliant::test_viscous {
namespace {

using test::at_time;
using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::stage_before_zero;
using test::TestStage;
using test::ViscousBody;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double dt = test::viscous_dt;

class Viscous : public test::EveryViscosity {};

INSTANTIATE_TEST_SUITE_P(Registry, Viscous, ::testing::ValuesIn(test::every_viscous_case()),
                         [](const auto& of) { return test::name_of(of.param.law) + test::name_of(of.param.body); });

TEST_P(Viscous, DeclaresWhatItIs) {
  EXPECT_EQ(body_.term->declaration().is_potential, !is_exact_);
  EXPECT_EQ(body_.term->declaration().symmetry, Symmetry::symmetric);
  EXPECT_EQ(body_.term->declaration().account, Account::stored);
  EXPECT_TRUE(body_.term->declaration().dissipates);
  EXPECT_EQ(body_.term->name(), std::visit([](const auto& law) { return law.name; }, GetParam().law));
}

TEST_P(Viscous, StayingWhereItHasBeenForEverCostsNothing) {
  const TestStage stage = body_.stage_from(at_time(0.0));
  body_.potential.begin_stage(stage.point);
  const auto moved = solid_.vector(at_time(0.01));
  EXPECT_LE(test::norm(body_.gradient(stage.q0).get()), 1e-13 * test::norm(body_.gradient(moved).get()));
  EXPECT_LE(body_.dissipation(stage, stage.q0), 1e-26 * body_.dissipation(stage, moved));
}

TEST_P(Viscous, InternalForcesBalance) {
  const TestStage stage = stage_before_zero(body_, dt);
  body_.potential.begin_stage(stage.point);
  const auto q = solid_.vector(at_time(0.0));
  const auto r = body_.gradient(q);
  const double size = test::norm(r.get());
  ASSERT_GT(size, 1.0);
  const auto [force, moment] = test::resultant(solid_, r.get(), q.get());
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(force[i], 0.0, 1e-13 * size);
    EXPECT_NEAR(moment[i], 0.0, 1e-13 * size);
  }
}

/// Where the motion was a time dt ago if it only turned, as a straight line or on the circle, and is now at time 0.
enum class Path { straight, circle };
test::Field turned_back(Path path, double length) {
  return [=](const Point& X) {
    const Point omega{3.0, -2.0, 5.0}, u = test::moving(X, 0.0);
    const auto Q = testing_states::rotation(-omega[0] * length, -omega[1] * length, -omega[2] * length);
    const Point x{X[0] + u[0], X[1] + u[1], X[2] + u[2]};
    Point y{};
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      y[i] = path == Path::circle ? Q(i, 0) * x[0] + Q(i, 1) * x[1] + Q(i, 2) * x[2]
                                  : x[i] - length * (omega[j] * x[k] - omega[k] * x[j]);
      y[i] -= X[i];
    }
    return y;
  };
}

// Differences of strains do not see a rotation however large; the exact rate does not see a velocity of rotation.
TEST_P(Viscous, RotationsCostNothing) {
  const TestStage stage = body_.stage_from(turned_back(is_exact_ ? Path::straight : Path::circle, dt));
  body_.potential.begin_stage(stage.point);
  const auto q = solid_.vector(at_time(0.0)), strained = solid_.vector(at_time(0.01));
  EXPECT_LE(test::norm(body_.gradient(q).get()), 1e-13 * test::norm(body_.gradient(strained).get()));
  EXPECT_LE(body_.dissipation(stage, q), 1e-26 * body_.dissipation(stage, strained));
}

// The difference of strains over a straight line to a turned place is dt^2/2 Fdot^T Fdot: it costs the secant its
// order, and the exact rate has as much on a circle.
TEST_P(Viscous, RotationsOnTheOtherPathCostTheFirstOrder) {
  const auto force = [&](double h) {
    const TestStage stage = body_.stage_from(turned_back(is_exact_ ? Path::circle : Path::straight, h), h);
    body_.potential.begin_stage(stage.point);
    return test::norm(body_.gradient(solid_.vector(at_time(0.0))).get());
  };
  const double order = body_.maxwell != nullptr ? 2.0 : 1.0;  // the spring yields while the dashpot is fast
  EXPECT_NEAR(std::log2(force(1e-3) / force(5e-4)), order, 0.01);
}

// Of a dashpot alone the forces take what is dissipated; with a spring before it, what is stored too. So it is in the
// limit of short stages, for the exact rate always.
TEST_P(Viscous, PowerIsStoredOrDissipated) {
  const auto q = solid_.vector(at_time(0.0));
  const auto gap = [&](double h) {
    const TestStage stage = stage_before_zero(body_, h);
    const double power = body_.power(stage, q), lost = body_.dissipation(stage, q);
    const double stored = (body_.energy(q, body_.end_stage(stage, q)) - body_.energy(stage.q0, stage.z0)) / h;
    EXPECT_GT(lost, 0.0);
    EXPECT_EQ(stored != 0.0, body_.maxwell != nullptr);
    return (power - lost - stored) / lost;
  };
  if (is_exact_) {
    EXPECT_NEAR(gap(0.1), 0.0, 1e-13);
    return;
  }
  const double coarse = gap(1e-4), fine = gap(5e-5);
  EXPECT_LT(std::abs(coarse), 0.02);
  EXPECT_NEAR(std::log2(coarse / fine), 1.0, 0.01);
}

// The discrete decay of stages of equal length, 1 / (1 + dt/tau) each, and by it exp(-t/tau).
TEST_P(Viscous, StressOfABranchRelaxes) {
  if (body_.maxwell == nullptr) return;
  const double tau = body_.maxwell->relaxation_time, h = tau / 50.0;
  TestStage stage(solid_, 0.0, h, at_time(0.0));
  stage.z0 = body_.potential.make_internal();
  stage.point.z0 = stage.z0.get();
  const double stored = body_.energy(stage.q0, stage.z0);
  double force = 0.0;
  for (int n = 1; n <= 40; ++n) {
    const double dissipation = body_.dissipation(stage, stage.q0);
    body_.potential.begin_stage(stage.point);
    const double next = test::norm(body_.gradient(stage.q0).get());
    if (n > 1) {
      EXPECT_NEAR(next / force, 1.0 / (1.0 + h / tau), 1e-12);
    }
    force = next;
    const Handle<Vec> z = body_.end_stage(stage, stage.q0);
    check(VecCopy(z.get(), stage.z0.get()));
    const double left = body_.energy(stage.q0, stage.z0);
    EXPECT_NEAR(left / stored, std::pow(1.0 + h / tau, -2.0 * n), 1e-12);
    EXPECT_NEAR(dissipation, 2.0 * left / tau, 1e-12 * dissipation);  // -d psi/dt of psi ~ exp(-2 t/tau)
  }
  EXPECT_NEAR(body_.energy(stage.q0, stage.z0) / stored, std::exp(-2.0 * 40.0 * h / tau), 0.02);
}

// A stage that is short beside tau leaves a spring, a long one nothing.
TEST_P(Viscous, ABranchIsASpringInFastMotion) {
  if (body_.maxwell == nullptr) return;
  const Maxwell& law = *body_.maxwell;
  const ElasticLawSpec spring =
      make_law("saint-venant-kirchhoff", {{"shear_modulus", law.shear_modulus}, {"bulk_modulus", law.bulk_modulus}});
  const auto q = solid_.vector(at_time(0.0));
  const auto force = [&](double h) {
    TestStage stage(solid_, 0.0, h);
    stage.z0 = body_.potential.make_internal();
    stage.point.z0 = stage.z0.get();
    body_.potential.begin_stage(stage.point);
    return body_.gradient(q);
  };
  const auto elastic = solid_.elastic(spring);
  IncrementalPotential alone(solid_.layout(), solid_.pattern(), {elastic.get()}, solid_.nothing_prescribed());
  const TestStage rest(solid_, 0.0, 1.0);
  alone.begin_stage(rest.point);
  const Handle<Vec> expected = alone.make_vector();
  alone.gradient(q.get(), expected.get());
  const double size = test::norm(expected.get()), tau = law.relaxation_time;
  EXPECT_LE(test::distance(force(1e-14 * tau).get(), expected.get()), 1e-12 * size);
  EXPECT_LE(test::norm(force(1e12 * tau).get()), 2e-12 * size);
}

// dr/dq by differences, times d.
Handle<Vec> jacobian_times(ViscousBody& body, const Handle<Vec>& q, const Handle<Vec>& d) {
  constexpr double h = 1e-3;  // r is a cubic: the fourth-order difference leaves rounding alone
  const auto at = [&](double s) { return body.gradient(test::moved(q.get(), s * h, d.get())); };
  const auto ahead = at(1.0), behind = at(-1.0), far_ahead = at(2.0), far_behind = at(-2.0);
  Handle<Vec> result = body.potential.make_vector();
  check(VecAXPY(result.get(), 8.0 / (12.0 * h), ahead.get()));
  check(VecAXPY(result.get(), -8.0 / (12.0 * h), behind.get()));
  check(VecAXPY(result.get(), -1.0 / (12.0 * h), far_ahead.get()));
  check(VecAXPY(result.get(), 1.0 / (12.0 * h), far_behind.get()));
  return result;
}

// Where there is no potential, the Hessian is the Jacobian at the stage's start, and further on all but its skew part.
TEST_P(Viscous, TheHessianIsTheSymmetricPartOfTheJacobian) {
  const auto end = solid_.vector(at_time(0.0));
  const auto d = solid_.vector(test::rough_field(0.05, 11));
  const Handle<Mat> K = body_.potential.make_hessian();
  const Handle<Vec> Kd = body_.potential.make_vector();
  std::array<double, 2> skew{}, symmetric{};
  for (const int level : {0, 1}) {
    const TestStage stage = body_.stage_from(at_time(level == 0 ? -0.02 : -0.01));
    body_.potential.begin_stage(stage.point);
    for (const Handle<Vec>* q : {&stage.q0, &end}) {
      body_.potential.hessian(q->get(), K.get(), Projection::none);
      check(MatMult(K.get(), d.get(), Kd.get()));
      const auto Jd = jacobian_times(body_, *q, d);
      const double size = test::norm(Jd.get()), error = test::distance(Kd.get(), Jd.get());
      ASSERT_GT(size, 1.0);
      if (q == &stage.q0 || !is_exact_) {
        EXPECT_LE(error, 1e-9 * size);
      } else {
        skew[level] = error / size;
        symmetric[level] = std::abs(test::dot(d.get(), Kd.get()) - test::dot(d.get(), Jd.get())) / size;
      }
    }
  }
  if (!is_exact_) return;
  EXPECT_NEAR(std::log2(skew[0] / skew[1]), 1.0, 0.1);
  EXPECT_NEAR(std::log2(symmetric[0] / symmetric[1]), 2.0, 0.1);
}

// A body that is quickly compressed would rather turn.
TEST_P(Viscous, ProjectedHessianIsPositiveSemidefiniteWhereTheHessianIsNot) {
  ViscousBody whole(MPI_COMM_SELF, file_, GetParam());
  const TestStage stage = whole.stage_from(test::at_rest);
  whole.potential.begin_stage(stage.point);
  const auto q = whole.solid.vector([](const Point& x) {
    return Point{-0.3 * x[0] + 0.01 * test::rough(x, 0, 2), -0.35 * x[1], -0.3 * x[2]};
  });
  const auto [lowest, highest] = test::extreme_eigenvalues(whole.potential, q.get(), Projection::none);
  const auto [projected, projected_highest] =
      test::extreme_eigenvalues(whole.potential, q.get(), Projection::positive_semidefinite);
  EXPECT_LT(lowest, -1e-3 * highest);
  EXPECT_GE(projected, -1e-13 * projected_highest);
  // Where the stress is tension, projection changes nothing.
  const auto stretched = whole.solid.vector([](const Point& x) { return Point{0.1 * x[0], 0.1 * x[1], 0.1 * x[2]}; });
  const auto exact = test::extreme_eigenvalues(whole.potential, stretched.get(), Projection::none);
  const auto same = test::extreme_eigenvalues(whole.potential, stretched.get(), Projection::positive_semidefinite);
  EXPECT_NEAR(exact[1], same[1], 1e-12 * exact[1]);
}

// Forces, powers, energies and internal variables are those of a run on one rank.
TEST_P(Viscous, NothingDependsOnTheNumberOfRanks) {
  ViscousBody whole(MPI_COMM_SELF, file_, GetParam());
  const auto results = [&](ViscousBody& body) {
    const TestStage stage = stage_before_zero(body, dt);
    const auto q = body.solid.vector(at_time(0.0));
    const Handle<Vec> z = body.end_stage(stage, q);
    body.potential.begin_stage(stage.point);
    return std::array{test::norm(body.gradient(q).get()), body.potential.value(q.get()), body.dissipation(stage, q),
                      body.energy(q, z)};
  };
  const auto mine = results(body_), expected = results(whole);
  EXPECT_EQ(expected[1] != 0.0, !is_exact_);
  EXPECT_EQ(expected[3] != 0.0, body_.maxwell != nullptr);
  for (std::size_t k = 0; k < mine.size(); ++k) EXPECT_NEAR(mine[k], expected[k], 1e-12 * std::abs(expected[k])) << k;
}

// Strains at completed steps are those of the configuration; a branch keeps what the method gave it.
TEST_P(Viscous, CompletedStepsHoldTheStrainsOfTheirConfiguration) {
  Handle<Vec> z = body_.potential.make_internal();
  EXPECT_EQ(static_cast<bool>(z), body_.term->num_internal() > 0);
  const bool holds_strain = test::rate_of(GetParam().law) == StrainRate::reconstructed;
  EXPECT_EQ(static_cast<bool>(z), holds_strain || body_.maxwell != nullptr);
  if (!z) return;
  const auto q = solid_.vector(at_time(0.0));
  check(VecSet(z.get(), 0.25));
  body_.potential.internal_variables().complete_step(nullptr, q.get(), z.get());
  const Handle<Vec> expected =
      holds_strain ? body_.stage_from(at_time(0.0)).z0.share() : body_.potential.make_internal();
  if (!holds_strain) check(VecSet(expected.get(), 0.25));
  EXPECT_LE(test::distance(z.get(), expected.get()), 1e-15 * test::norm(expected.get()));
}

TEST(RelativeModuli, ArePartsOfTheElasticOnes) {
  const Scratch scratch(MPI_COMM_WORLD);
  const BodySpec spec{2, Shape::jittered, 2};
  const std::string file = scratch.file("body.msh", [&](const std::string& f) { test::write_body(f, spec); });
  const auto forces = [&](const ViscosityVariant& law) {
    ViscousBody body(comm, file, {law, spec});
    const TestStage stage = stage_before_zero(body, dt);
    body.potential.begin_stage(stage.point);
    return body.gradient(body.solid.vector(at_time(0.0)));
  };
  const auto& [shear, bulk] = test::stiffness_at_rest;
  const auto expected = forces(WithStrainRate{KelvinVoigt{0.02 * shear, 0.02 * bulk}, StrainRate::exact});
  const auto proportional = forces(WithStrainRate{StiffnessProportional{0.02}, StrainRate::exact});
  EXPECT_LE(test::distance(proportional.get(), expected.get()), 1e-14 * test::norm(expected.get()));
  const auto branch = forces(Maxwell{0.3 * shear, 0.2 * bulk, 0.1});
  const auto part = forces(Maxwell{0.3, 0.2, 0.1, Moduli::relative});
  EXPECT_LE(test::distance(part.get(), branch.get()), 1e-14 * test::norm(branch.get()));
}

// Of the body's mass as a whole: the elements hold an affine velocity exactly.
TEST(MassProportionalDamping, TakesItsPartOfTheMomentum) {
  const Scratch scratch(MPI_COMM_WORLD);
  const BodySpec spec{2, Shape::jittered, 2};
  const std::string file = scratch.file("body.msh", [&](const std::string& f) { test::write_body(f, spec); });
  const Solid solid(comm, file, 2, 2);
  constexpr double alpha = 0.7, density = 3.0;
  for (const Mass mass : {Mass::consistent, Mass::lumped}) {
    const auto term = solid.mass_damping(alpha * density, mass);
    const auto inertia = solid.inertia(density, mass);
    const auto v = solid.vector([](const Point& x) { return Point{1.0 + x[1], -2.0 * x[2], 0.5}; });
    TestStage stage(solid, 0.0, dt, test::rough_field(0.1, 1));
    const auto q = test::moved(stage.q0.get(), dt, v.get());
    IncrementalPotential potential(solid.layout(), solid.pattern(), {term.get()}, solid.nothing_prescribed());
    potential.begin_stage(stage.point);
    const Handle<Vec> r = potential.make_vector();
    potential.gradient(q.get(), r.get());
    const auto [force, moment] = test::resultant(solid, r.get(), stage.q0.get());
    const Momenta m =
        inertia->momenta(solid.layout().coordinates, test::local_values(stage.q0.get()), test::local_values(v.get()));
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(force[i], alpha * sum(comm, m.linear[i]), 1e-12 * density);
      EXPECT_NEAR(moment[i], alpha * sum(comm, m.angular[i]), 1e-12 * density);
    }
    const auto power = potential.accounts().powers(q.get(), v.get(), r.get());
    const double lost = 2.0 * alpha * sum(comm, inertia->kinetic_energy(test::local_values(v.get())));
    EXPECT_NEAR(power[0].dissipated, lost, 1e-12 * lost);
    EXPECT_NEAR(power[0].exerted, -lost, 1e-12 * lost);
    EXPECT_NEAR(potential.value(q.get()), 0.5 * dt * lost, 1e-12 * lost);
  }
}

TEST(StrainRateFor, KeepsTheOrderOfEveryMethodWithAPotentialWhereThereIsOne) {
  for (const Method& method : methods()) {
    const bool survives = method.name != "dirk23" && method.name != "dirk33" && method.name != "implicit-midpoint";
    const StrainRate with_potential = method.order == 1 ? StrainRate::secant : StrainRate::reconstructed;
    EXPECT_EQ(strain_rate_for(method), survives ? with_potential : StrainRate::exact) << method.name;
  }
}

}  // namespace
}  // namespace pliant::test_viscous
