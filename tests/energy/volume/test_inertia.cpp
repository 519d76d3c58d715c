// Mass: what it weighs, what it carries.
#include "energy/solid.hpp"
#include "energy/volume/inertia.hpp"

#include <algorithm>
#include <ostream>

namespace pliant::test_inertia {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double density = 1200.0;

struct MassCase {
  BodySpec body;
  Mass mass;
  std::string name() const { return test::name_of(body) + (mass == Mass::lumped ? "Lumped" : "Consistent"); }
};

std::ostream& operator<<(std::ostream& out, const MassCase& c) {
  return out << c.name();
}

class Masses : public ::testing::TestWithParam<MassCase> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, GetParam().body.order, 2};
  std::unique_ptr<Inertia> inertia_ = solid_.inertia(density, GetParam().mass);
  double volume_ = GetParam().body.volume();
};

INSTANTIATE_TEST_SUITE_P(Bodies, Masses,
                         ::testing::Values(MassCase{{1, Shape::jittered, 3}, Mass::consistent},
                                           MassCase{{1, Shape::jittered, 3}, Mass::lumped},
                                           MassCase{{2, Shape::jittered, 2}, Mass::consistent},
                                           MassCase{{2, Shape::jittered, 2}, Mass::lumped},
                                           MassCase{{2, Shape::curved, 2}, Mass::consistent},
                                           MassCase{{2, Shape::curved, 2}, Mass::lumped}),
                         [](const auto& of) { return of.param.name(); });

TEST_P(Masses, TotalIsDensityTimesVolume) {
  EXPECT_NEAR(sum(comm, inertia_->mass().total()), density * volume_, 1e-12 * density);
}

// v = a + B X: the elements hold it exactly; its kinetic energy on the unit cube in closed form.
TEST_P(Masses, KineticEnergyAndMomentaOfAnAffineVelocity) {
  const auto velocity = [](const Point& x) { return Point{1.0 + 2.0 * x[1], -0.5, 3.0 * x[0]}; };
  const auto v = test::local_values(solid_.vector(velocity).get());
  const std::vector<double> at_rest(v.size(), 0.0);
  const auto momenta = inertia_->momenta(solid_.layout().coordinates, at_rest, v);
  if (GetParam().body.shape == Shape::curved) {
    // Uniform motion is enough: p = m v, E = m v^2 / 2.
    const auto w = test::local_values(solid_.vector([](const Point&) { return Point{2.0, -1.0, 0.5}; }).get());
    EXPECT_NEAR(sum(comm, inertia_->kinetic_energy(w)), 0.5 * 5.25 * density * volume_, 1e-11 * density);
    const auto p = inertia_->momenta(solid_.layout().coordinates, at_rest, w).linear;
    EXPECT_NEAR(sum(comm, p[0]), 2.0 * density * volume_, 1e-11 * density);
    return;
  }
  // int v dX = (2, -1/2, 3/2); lumping keeps the mass but not each first moment on cells of different shape.
  EXPECT_NEAR(sum(comm, momenta.linear[1]), -0.5 * density, 1e-12 * density);
  if (GetParam().mass == Mass::lumped) return;
  EXPECT_NEAR(sum(comm, momenta.linear[0]), 2.0 * density, 1e-12 * density);
  EXPECT_NEAR(sum(comm, momenta.linear[2]), 1.5 * density, 1e-12 * density);
  // 1/2 int (1 + 2 y)^2 + 1/4 + 9 x^2
  EXPECT_NEAR(sum(comm, inertia_->kinetic_energy(v)), 0.5 * (13.0 / 3.0 + 0.25 + 3.0) * density, 1e-12 * density);
  // int X x v: y v_z - z v_y = 3/4 + 1/4, z v_x - x v_z = 1 - 1, x v_y - y v_x = -1/4 - (1/2 + 2/3)
  EXPECT_NEAR(sum(comm, momenta.angular[0]), 1.0 * density, 1e-12 * density);
  EXPECT_NEAR(sum(comm, momenta.angular[1]), 0.0, 1e-12 * density);
  EXPECT_NEAR(sum(comm, momenta.angular[2]), (-0.25 - 7.0 / 6.0) * density, 1e-12 * density);
}

TEST_P(Masses, AreSymmetricAndPositive) {
  const auto product = [&](const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<double> My(y.size(), 0.0);
    inertia_->mass().add_times(y, My);
    double mine = 0.0;
    for (PetscInt i = 0; i < 3 * solid_.layout().num_owned_nodes; ++i) mine += x[i] * My[i];
    return sum(comm, mine);
  };
  const auto x = test::local_values(solid_.vector(test::rough_field(1.0, 1)).get());
  const auto y = test::local_values(solid_.vector(test::rough_field(1.0, 2)).get());
  const double size = std::sqrt(product(x, x) * product(y, y));
  EXPECT_GT(product(x, x), 0.0);
  EXPECT_GT(product(y, y), 0.0);
  EXPECT_NEAR(product(x, y), product(y, x), 1e-14 * size);
}

TEST_P(Masses, LumpedOnesArePositiveAtEveryNode) {
  if (GetParam().mass != Mass::lumped) return;
  const std::vector<double> ones(3 * static_cast<std::size_t>(solid_.layout().num_local_nodes), 1.0);
  std::vector<double> m(ones.size(), 0.0);
  inertia_->mass().add_times(ones, m);
  for (PetscInt i = 0; i < 3 * solid_.layout().num_owned_nodes; ++i) EXPECT_GT(m[i], 0.0);
}

// The Hessian is M / dt^2, the gradient at rest at the start is -M v0 / dt, the value that of the formula.
TEST_P(Masses, HessianIsTheMassOverDt2) {
  const double dt = 0.05;
  const TestStage stage(solid_, 0.0, dt, test::rough_field(0.3, 3), test::rough_field(1.0, 4));
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {inertia_.get()}, solid_.nothing_prescribed());
  potential.begin_stage(stage.point);
  const Handle<Mat> K = potential.make_hessian();
  const auto x = solid_.vector(test::rough_field(1.0, 1));
  const Handle<Vec> Kx = potential.make_vector(), r = potential.make_vector();
  potential.hessian(x.get(), K.get(), Projection::none);
  check(MatMult(K.get(), x.get(), Kx.get()));
  const auto local = test::local_values(x.get()), velocity = test::local_values(stage.v0.get());
  std::vector<double> Mx(local.size(), 0.0), Mv(local.size(), 0.0);
  inertia_->mass().add_times(local, Mx);
  inertia_->mass().add_times(velocity, Mv);
  potential.gradient(stage.q0.get(), r.get());
  const ConstArrayView product(Kx.get()), gradient(r.get());
  for (PetscInt i = 0; i < 3 * solid_.layout().num_owned_nodes; ++i) {
    EXPECT_NEAR(product[i], Mx[i] / (dt * dt), 1e-12 * density / (dt * dt));
    EXPECT_NEAR(gradient[i], -Mv[i] / dt, 1e-12 * density / dt);
  }
}

// Adding to zero and setting what was something else come to the same, digit by digit.
TEST_P(Masses, HessianCanBeSetWhateverTheMatrixWas) {
  LocalStage at;
  at.dt = 0.05;
  const Handle<Mat> added = make_matrix(solid_.layout(), solid_.pattern()),
                    set = make_matrix(solid_.layout(), solid_.pattern());
  {
    BlockWriter writer(solid_.pattern(), added.get());
    inertia_->add_hessian(at, {}, writer, Projection::none);
    writer.finish();
  }
  check(MatCopy(added.get(), set.get(), SAME_NONZERO_PATTERN));
  check(MatShift(set.get(), 7.0));
  {
    BlockWriter writer(solid_.pattern(), set.get());
    ASSERT_TRUE(inertia_->set_hessian(at, writer));
    writer.finish();
  }
  PetscReal size = 0.0;
  check(MatNorm(added.get(), NORM_FROBENIUS, &size));
  EXPECT_GT(size, 0.0);
  PetscBool is_equal = PETSC_FALSE;
  check(MatEqual(added.get(), set.get(), &is_equal));
  EXPECT_TRUE(is_equal);
}

// Where the body is after a stage of free flight, Phi is least: q = q0 + dt v0, lower by dt^2/2 |v0|_M^2 / dt^2.
TEST_P(Masses, FreeFlightIsTheMinimum) {
  const double dt = 0.05;
  const TestStage stage(solid_, 0.0, dt, test::rough_field(0.3, 3), test::rough_field(1.0, 4));
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {inertia_.get()}, solid_.nothing_prescribed());
  potential.begin_stage(stage.point);
  const auto q = test::moved(stage.q0.get(), dt, stage.v0.get());
  const Handle<Vec> r = potential.make_vector();
  potential.gradient(q.get(), r.get());
  EXPECT_LE(test::norm(r.get()), 1e-11 * density);
  const double kinetic = sum(comm, inertia_->kinetic_energy(test::local_values(stage.v0.get())));
  EXPECT_NEAR(potential.value(q.get()), -kinetic, 1e-12 * kinetic);
}

TEST(NodalMasses, SumToTheMassOfTheirBodies) {
  const Scratch scratch(comm);
  const auto file = scratch.file("body.msh", [](const std::string& f) { test::write_body(f, {2, Shape::curved, 2}); });
  const Solid solid(comm, file, 2, 2);
  const auto masses = nodal_masses<2>(solid.layout(), std::get<1>(solid.groups()), {density});
  double mine = 0.0;
  for (PetscInt a = 0; a < solid.layout().num_local_nodes; ++a) {
    mine += masses[a];
    if (a >= solid.layout().num_owned_nodes) {
      EXPECT_EQ(masses[a], 0.0);
    }
  }
  EXPECT_NEAR(sum(comm, mine), density * test::bent_volume, 1e-12 * density);
}

}  // namespace
}  // namespace pliant::test_inertia
