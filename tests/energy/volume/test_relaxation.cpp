// Relaxation, creep and rigid motion against closed forms, and losses along any motion: every mechanism of damping by
// every method.
#include "energy/dense_newton.hpp"
#include "energy/volume/viscous_body.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"

#include <algorithm>

namespace pliant::test_relaxation {
namespace {

using test::BodySpec;
using test::Field;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

constexpr double tau = 0.1;
const BodySpec small_body{1, Shape::straight, 1};

/// A motion of the whole body that is given in advance.
struct Path {
  std::function<Field(double)> u;  ///< displacement at a time [m]
  std::function<Field(double)> v;  ///< velocity [m/s]
};

/// With rates by differences; any velocity would do.
Path along(const std::function<Field(double)>& u) {
  return {u, [u](double t) {
            return [ahead = u(t + 1e-4), behind = u(t - 1e-4)](const Point& X) {
              const Point a = ahead(X), b = behind(X);
              return Point{(a[0] - b[0]) / 2e-4, (a[1] - b[1]) / 2e-4, (a[2] - b[2]) / 2e-4};
            };
          }};
}

struct Mechanism {
  std::string name;
  std::function<std::unique_ptr<EnergyTerm>(const Solid&)> make;
};

std::vector<Mechanism> every_mechanism() {
  std::vector<Mechanism> all;
  for (const auto& law : test::every_viscosity()) {
    all.push_back({test::name_of(law), [law](const Solid& solid) { return solid.viscous(law); }});
  }
  all.push_back({"prony", [](const Solid& s) { return s.prony({{0.5, tau}, {1.5, 0.3}}, "neo-hookean"); }});
  all.push_back({"massproportional", [](const Solid& s) { return s.mass_damping(2.0, Mass::consistent); }});
  return all;
}

/// What a term does along a path.
struct Losses {
  double total = 0.0;                                ///< [J]
  double least_rate = HUGE_VAL, largest_rate = 0.0;  ///< at the end of a stage [W]
  Handle<Vec> z;                                     ///< at the end
};

/// Every entry is prescribed: there is no equation to solve. Alone on this rank.
Losses follow(const Solid& solid, IncrementalPotential& potential, const Method& method, const Path& path,
              std::array<double, 2> ends_and_steps) {
  const auto [end, num_steps] = ends_and_steps;
  Losses losses;
  System system{[](const StagePoint&, Vec) { return StageReport{}; }};
  const auto copy = [&](const Field& field, Vec to) { check(VecCopy(solid.vector(field).get(), to)); };
  system.motion.start_stage = [&](const StagePoint& stage, Vec q) {
    copy(path.u(stage.time), q);
    copy(path.v(stage.time), stage.v0);
    check(VecWAXPY(stage.q0, -stage.dt, stage.v0, q));
  };
  system.motion.complete_step = [&](const Step& step, Vec q, Vec v) {
    copy(path.u(step.time), q);
    copy(path.v(step.time), v);
  };
  const Handle<Vec> r = potential.make_vector();
  system.quadratures.rates = [&](const StagePoint& stage, Vec q, Vec v, Vec, std::span<double> rates) {
    potential.begin_stage(stage);
    rates[0] = potential.accounts().powers(q, v, r.get())[0].dissipated;
    losses.least_rate = std::min(losses.least_rate, rates[0]);
    losses.largest_rate = std::max(losses.largest_rate, rates[0]);
  };
  const auto q = solid.vector(path.u(0.0)), v = solid.vector(path.v(0.0));
  const Handle<Vec> z = potential.make_internal();
  if (z) {
    system.internal = potential.internal_variables();
    system.internal.complete_step(nullptr, q.get(), z.get());
  }
  const double nothing = 0.0;
  Integrator integrator({method, Startup::dirk33}, system, {0.0, q.get(), v.get(), z.get(), {&nothing, 1}});
  const int steps = static_cast<int>(num_steps);
  for (int n = 1; n <= steps; ++n) {
    const double time = end * n / steps;
    const StepAttempt attempt = integrator.attempt({time, time - integrator.state().time});
    losses.total = attempt.w[0];
    integrator.accept(attempt);
  }
  if (z) {
    losses.z = potential.make_internal();
    check(VecCopy(integrator.state().z.get(), losses.z.get()));
  }
  return losses;
}

class GivenMotion : public test::EveryMethod {
 protected:
  Scratch scratch_{MPI_COMM_SELF};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) { test::write_body(f, small_body); });
  Solid solid_{MPI_COMM_SELF, file_, 1, 0};

  IncrementalPotential potential_of(const EnergyTerm& term) const {
    return {solid_.layout(), solid_.pattern(), {&term}, solid_.nothing_prescribed()};
  }
};

INSTANTIATE_TEST_SUITE_P(Table, GivenMotion, test::every_method(), test::method_name);

// Spins of 5 rad/s about an oblique axis. `secant` sees the straight lines between places on a circle.
TEST_P(GivenMotion, ARigidSpinDissipatesNothing) {
  static constexpr Point omega{4.0, -2.0, 2.0};
  const auto rotation = [](double t) {
    const double angle = 0.1 + t;  // which has a direction at the start too
    return testing_states::rotation(omega[0] * angle, omega[1] * angle, omega[2] * angle);
  };
  const Path spin{[=](double t) {
                    return [Q = rotation(t)](const Point& X) {
                      Point u{};
                      for (int i = 0; i < 3; ++i) u[i] = Q(i, 0) * X[0] + Q(i, 1) * X[1] + Q(i, 2) * X[2] - X[i];
                      return u;
                    };
                  },
                  [=](double t) {
                    return [Q = rotation(t)](const Point& X) {
                      Point x{};
                      for (int i = 0; i < 3; ++i) x[i] = Q(i, 0) * X[0] + Q(i, 1) * X[1] + Q(i, 2) * X[2];
                      return Point{omega[1] * x[2] - omega[2] * x[1], omega[2] * x[0] - omega[0] * x[2],
                                   omega[0] * x[1] - omega[1] * x[0]};
                    };
                  }};
  const Path strained = along([](double t) { return test::at_time(t); });
  for (const Mechanism& mechanism : every_mechanism()) {
    if (mechanism.name == "massproportional") continue;  // which damps it by purpose
    const auto term = mechanism.make(solid_);
    IncrementalPotential potential = potential_of(*term);
    const double size = follow(solid_, potential, GetParam(), strained, {0.4, 8}).largest_rate;
    const Losses losses = follow(solid_, potential, GetParam(), spin, {0.4, 8});
    if (mechanism.name == "kelvinvoigtsecant") {
      EXPECT_GT(losses.largest_rate, 1e-4 * size);
    } else {
      EXPECT_LE(losses.largest_rate, 1e-24 * size) << mechanism.name;
      EXPECT_LE(std::abs(losses.total), 1e-24 * size) << mechanism.name;
    }
  }
}

TEST_P(GivenMotion, NoRateOfLossIsNegative) {
  for (const double speed : {1.0, 4.0}) {
    const Path path = along([speed](double t) { return test::at_time(speed * t); });
    for (const Mechanism& mechanism : every_mechanism()) {
      const auto term = mechanism.make(solid_);
      IncrementalPotential potential = potential_of(*term);
      const Losses losses = follow(solid_, potential, GetParam(), path, {0.6, 15});
      EXPECT_GT(losses.largest_rate, 0.1) << mechanism.name;
      EXPECT_GE(losses.least_rate, -1e-15 * losses.largest_rate) << mechanism.name;
    }
  }
}

// Stretched by a third at time 0 and held: the stress of a branch is g S_e exp(-t/tau), whatever the law and the
// strain.
TEST_P(GivenMotion, AHeldStrainRelaxesExponentially) {
  Field stretched = [](const Point& X) { return Point{0.33 * X[0], -0.1 * X[1] + 0.2 * X[0], 0.05 * X[2]}; };
  const Path held{[=](double) { return stretched; }, [](double) { return test::at_rest; }};
  std::vector<Mechanism> branches{{"maxwell", [](const Solid& s) { return s.viscous(Maxwell{300.0, 500.0, tau}); }}};
  for (const char* law : {"saint-venant-kirchhoff", "neo-hookean"}) {
    branches.push_back({law, [law](const Solid& s) { return s.prony({{0.7, tau}}, law); }});
  }
  for (const Mechanism& branch : branches) {
    const auto term = branch.make(solid_);
    IncrementalPotential potential = potential_of(*term);
    // In a stage that is short beside tau nothing is forgotten.
    const auto force = [&](Vec z) {
      TestStage stage(solid_, 0.0, 1e-15 * tau, stretched);
      stage.point.z0 = z;
      potential.begin_stage(stage.point);
      Handle<Vec> r = potential.make_vector();
      potential.gradient(stage.q0.get(), r.get());
      return r;
    };
    const Handle<Vec> at_once = force(potential.make_internal().get());
    const double size = test::norm(at_once.get());
    if (branch.name != "maxwell") {
      const auto elastic = solid_.elastic(make_law(branch.name, test::prony_modulus, 0.3));
      IncrementalPotential alone = potential_of(*elastic);
      const TestStage rest(solid_, 0.0, 1.0);
      alone.begin_stage(rest.point);
      const Handle<Vec> r = alone.make_vector();
      alone.gradient(solid_.vector(stretched).get(), r.get());
      check(VecScale(r.get(), 0.7));
      EXPECT_LE(test::distance(at_once.get(), r.get()), 1e-13 * size);
    }
    std::array<double, 2> errors{};
    for (const int level : {0, 1}) {
      const Losses losses = follow(solid_, potential, GetParam(), held, {tau, level == 0 ? 20.0 : 40.0});
      const Handle<Vec> left = force(losses.z.get());
      const double part = test::dot(left.get(), at_once.get()) / (size * size);
      check(VecAXPY(left.get(), -part, at_once.get()));
      EXPECT_LE(test::norm(left.get()), 1e-13 * size) << "another direction";
      errors[level] = std::abs(part - std::exp(-1.0));
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), GetParam().order, 0.15) << branch.name;
    EXPECT_LT(errors[1], 0.02);
  }
}

/// A bar pulled by `load` [Pa] from rest, strains of 1e-10 and nu = 0: sigma = E_0 eps + what the mechanism adds.
struct CreepCase {
  std::string name;
  double modulus;  ///< E_0 [Pa]
  Mechanism mechanism;
  std::function<double(double)> strain;  ///< over the load [1/Pa]
};

// Solid of E_0 = 1000 Pa; a branch of E_1 = 600 Pa, a dashpot of 2 eta = 100 Pa s: one time of creep each.
std::vector<CreepCase> every_creep(const Method& method) {
  constexpr double E0 = 1000.0, E1 = 600.0, viscosity = 100.0;
  const auto kelvin_voigt = [=](double t) { return (1.0 - std::exp(-t * E0 / viscosity)) / E0; };
  const auto solid = [=](double t) { return (1.0 - E1 / (E0 + E1) * std::exp(-t * E0 / (tau * (E0 + E1)))) / E0; };
  const double eta = viscosity / 2.0;
  const StrainRate rate = strain_rate_for(method);
  std::vector<CreepCase> cases{{"kelvin-voigt",
                                E0,
                                {"",
                                 [=](const Solid& s) {
                                   return s.viscous(WithStrainRate{KelvinVoigt{eta, eta / 1.5}, rate});
                                 }},
                                kelvin_voigt}};
  // At once the bar yields by the springs: the strain is no state of an ordinary differential equation, and methods
  // whose last stage is not the end of the step have other orders in it.
  if (!method.stiffly_accurate) return cases;
  cases.push_back({"standard linear solid",
                   E0,
                   {"",
                    [=](const Solid& s) {
                      return s.viscous(Maxwell{E1 / 2.0, E1 / 3.0, tau});
                    }},
                   solid});
  cases.push_back({"prony",
                   E0,
                   {"",
                    [=](const Solid& s) {
                      return s.prony({{E1 / E0, tau}}, "linear", E0, 0.0);
                    }},
                   solid});
  cases.push_back({"maxwell",
                   0.0,
                   {"",
                    [=](const Solid& s) {
                      return s.viscous(Maxwell{E1 / 2.0, E1 / 3.0, tau});
                    }},
                   [=](double t) { return (1.0 + t / tau) / E1; }});
  return cases;
}

TEST_P(GivenMotion, ALoadedBarCreepsAsItsFormulaSays) {
  constexpr double load = 1e-7, end = 0.1;
  std::vector<char> held = solid_.nothing_prescribed();
  for (PetscInt a = 0; a < solid_.layout().num_local_nodes; ++a) {
    const Point X = solid_.layout().position(a);
    for (int i = 0; i < 3; ++i) held[3 * a + i] = X[i] < 1e-9;
  }
  for (const CreepCase& c : every_creep(GetParam())) {
    const auto mechanism = c.mechanism.make(solid_);
    const auto elastic = solid_.elastic(make_law("linear", std::max(c.modulus, 1.0), 0.0));
    const auto pull = solid_.traction({Expression(load), Expression(), Expression()});
    std::vector<const EnergyTerm*> terms{mechanism.get(), pull.get()};
    if (c.modulus > 0.0) terms.push_back(elastic.get());
    IncrementalPotential potential(solid_.layout(), solid_.pattern(), terms, held);
    std::array<double, 2> errors{};
    for (const int level : {0, 1}) {
      const double start = load * c.strain(0.0);
      const auto q = solid_.vector([=](const Point& X) { return Point{start * X[0], 0.0, 0.0}; });
      const auto v = solid_.vector(test::at_rest);
      System system{test::dense_newton(potential, 1e-24)};
      const Handle<Vec> z = potential.make_internal();
      if (z) {
        system.internal = potential.internal_variables();
        system.internal.complete_step(nullptr, q.get(), z.get());
      }
      Integrator integrator({GetParam(), Startup::dirk33}, system, {0.0, q.get(), v.get(), z.get(), {}});
      const int num_steps = level == 0 ? 20 : 40;
      for (int n = 1; n <= num_steps; ++n) {
        const double time = end * n / num_steps;
        const StepAttempt attempt = integrator.attempt({time, time - integrator.state().time});
        ASSERT_EQ(attempt.report.outcome, StageOutcome::converged) << c.name;
        integrator.accept(attempt);
      }
      PetscReal longest = 0.0;
      check(VecNorm(integrator.state().q.get(), NORM_INFINITY, &longest));
      errors[level] = std::abs(longest / (load * c.strain(end)) - 1.0);
    }
    if (c.modulus == 0.0) {  // strains grow linearly: exact but for the square of the strain
      EXPECT_LE(errors[1], 1e-6) << c.name;
      continue;
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), GetParam().order, 0.15) << c.name << ": " << errors[1];
    EXPECT_LT(errors[1], 0.02) << c.name;
  }
}

}  // namespace
}  // namespace pliant::test_relaxation
