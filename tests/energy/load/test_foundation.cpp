// Springs and dashpots to the ground: resultants and energies in closed form, and the orders of all methods.
#include "energy/load/foundation.hpp"
#include "energy/solid.hpp"
#include "petsc/collective.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"

#include <cmath>

namespace pliant::test_foundation {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double spring = 30.0, dashpot = 2.0;

class Foundations : public ::testing::TestWithParam<BodySpec> {
 protected:
  IncrementalPotential alone(const EnergyTerm& term) const {
    return {solid_.layout(), solid_.pattern(), {&term}, solid_.nothing_prescribed()};
  }
  std::unique_ptr<Foundation> on_a_curve() const {
    const auto nodes = nodes_of_group(solid_.mesh(), solid_.layout(), test::group_named(solid_.mesh(), "edge"));
    const auto total = sum(comm, static_cast<PetscInt64>(nodes.size()));
    return std::make_unique<Foundation>(nodal_foundation(solid_.pattern(), nodes, 1.0 / static_cast<double>(total)),
                                        FoundationStiffness{spring, dashpot});
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam()); });
  Solid solid_{comm, file_, GetParam().order, 2};
};

INSTANTIATE_TEST_SUITE_P(Bodies, Foundations,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

// A body moved by u in a stage of length dt; the loaded face has the area 1 m^2 and the normal e_x, the nodes of the
// curve count 1 in all.
TEST_P(Foundations, PullBackAndTakeEnergy) {
  const Point u{0.3, -0.2, 0.5};
  const double dt = 0.1, square = 0.3 * 0.3 + 0.2 * 0.2 + 0.5 * 0.5;
  const TestStage stage(solid_, 0.0, dt);
  const auto q = solid_.vector([&](const Point&) { return u; });
  const auto all = solid_.foundation({spring, dashpot}, FoundationDirection::all);
  const auto normal = solid_.foundation({spring, dashpot}, FoundationDirection::normal);
  const auto nodal = on_a_curve();
  for (const Foundation* term : {all.get(), normal.get(), nodal.get()}) {
    auto potential = alone(*term);
    potential.begin_stage(stage.point);
    const Handle<Vec> r = potential.make_vector();
    potential.gradient(q.get(), r.get());
    const Point force = test::resultant(solid_, r.get(), q.get()).force;
    for (int i = 0; i < 3; ++i) {
      const double resisted = term == normal.get() && i > 0 ? 0.0 : u[i];
      EXPECT_NEAR(force[i], (spring + dashpot / dt) * resisted, 1e-12);
    }
    const double resisted_square = term == normal.get() ? 0.3 * 0.3 : square;
    EXPECT_NEAR(potential.accounts().energies({}, q.get(), nullptr)[0], 0.5 * spring * resisted_square, 1e-13);
    EXPECT_NEAR(potential.value(q.get()), 0.5 * (spring + dashpot / dt) * resisted_square, 1e-12);
    const auto power =
        potential.accounts().powers(q.get(),
                                    solid_.vector([&](const Point&) {
                                            return Point{u[0] / dt, u[1] / dt, u[2] / dt};
                                          })
                                        .get(),
                                    r.get())[0];
    EXPECT_NEAR(power.dissipated, dashpot * resisted_square / (dt * dt), 1e-10);
    EXPECT_NEAR(power.exerted, -(spring + dashpot / dt) * resisted_square / dt, 1e-10);
  }
}

// Stiffness c0 and viscosity c1 in proportion to the mass of each node: every node is a damped oscillator by itself,
//
//     u'' + c1 u' + c0 u = 0,    u = e^{-c1 t/2} (u0 cos wt + (v0 + c1 u0/2)/w sin wt),    w^2 = c0 - c1^2/4
class FoundationOrders : public test::EveryMethod {
 protected:
  static constexpr double density = 3.0, end_time = 1.0, c0 = 30.0, c1 = 4.0;

  FoundationMatrix proportional_to_mass() const {
    const auto unit = solid_.gravity(density, {Expression(1.0), Expression(), Expression()});
    const auto masses = unit->forces(0.0);
    FoundationMatrix matrix;
    for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a) {
      matrix.blocks.push_back({a, a, solid_.pattern().block(a, a), masses[3 * a] * identity<double>()});
    }
    return matrix;
  }

  /// The equation is linear and its matrix diagonal.
  StageSolve solve() {
    return [this](const StagePoint& stage, Vec q) {
      potential_.begin_stage(stage);
      potential_.gradient(q, r_.get());
      potential_.hessian(q, hessian_.get(), Projection::none);
      check(MatGetDiagonal(hessian_.get(), diagonal_.get()));
      check(VecPointwiseDivide(r_.get(), r_.get(), diagonal_.get()));
      check(VecAXPY(q, -1.0, r_.get()));
      return StageReport{};
    };
  }

  /// Errors in q and v at the end.
  std::array<double, 2> errors(int num_steps) {
    const auto start = test::rough_field(0.1, 1), velocity = test::rough_field(0.4, 2);
    System system{solve()};
    Integrator integrator({GetParam(), Startup::dirk33}, system,
                          {0.0, solid_.vector(start).get(), solid_.vector(velocity).get(), nullptr, {}});
    for (int n = 1; n <= num_steps; ++n) {
      const double time = end_time * n / num_steps;
      integrator.accept(integrator.attempt({time, time - integrator.state().time}));
    }
    const double w = std::sqrt(c0 - 0.25 * c1 * c1), cosine = std::cos(w * end_time), sine = std::sin(w * end_time);
    const double decay = std::exp(-0.5 * c1 * end_time);
    const auto u = solid_.vector([&](const Point& x) {
      Point result{};
      for (int i = 0; i < 3; ++i) {
        result[i] = decay * (start(x)[i] * cosine + (velocity(x)[i] + 0.5 * c1 * start(x)[i]) / w * sine);
      }
      return result;
    });
    const auto v = solid_.vector([&](const Point& x) {
      Point result{};
      for (int i = 0; i < 3; ++i) {
        result[i] = decay * (velocity(x)[i] * cosine - (c0 * start(x)[i] + 0.5 * c1 * velocity(x)[i]) / w * sine);
      }
      return result;
    });
    return {test::distance(integrator.state().q.get(), u.get()), test::distance(integrator.state().v.get(), v.get())};
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 1});
  });
  Solid solid_{comm, file_, 1, 2};
  std::unique_ptr<Inertia> inertia_ = solid_.inertia(density, Mass::lumped);
  Foundation foundation_{proportional_to_mass(), {c0, c1}};
  IncrementalPotential potential_{
      solid_.layout(), solid_.pattern(), {inertia_.get(), &foundation_}, solid_.nothing_prescribed()};
  Handle<Mat> hessian_ = potential_.make_hessian();
  Handle<Vec> r_ = potential_.make_vector(), diagonal_ = potential_.make_vector();
};

INSTANTIATE_TEST_SUITE_P(Methods, FoundationOrders, test::every_method(), test::method_name);

TEST_P(FoundationOrders, AreThoseOfTheMethods) {
  const auto coarse = errors(160), fine = errors(320);
  for (const int part : {0, 1}) {
    EXPECT_NEAR(std::log2(coarse[part] / fine[part]), GetParam().order, 0.1)
        << (part == 0 ? "q" : "v") << ": errors " << coarse[part] << ", " << fine[part];
  }
}

}  // namespace
}  // namespace pliant::test_foundation
