// Friction and damping between bodies: derivatives, balance of forces, dissipation, and the same numbers on every
// number of ranks.
#include "energy/body_contact.hpp"
#include "energy/near_springs.hpp"

#include <optional>
#include <ostream>

namespace pliant::test_body_drag {
namespace {

using test::Point;
using test::Scratch;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.3, between = 1.0 + 0.5 * gap, dt = 0.1;
constexpr double stick_velocity = 0.5;

struct DragCase {
  int order;
  FrictionUpdate update;
};

std::ostream& operator<<(std::ostream& out, const DragCase& c) {
  return out << "P" << c.order << (c.update == FrictionUpdate::frozen ? " frozen" : " iterated");
}

/// Two cubes that have come near each other askew, with the facets of one across those of the other.
test::Field near_by(double closer, double shift) {
  return [=](const Point& x) {
    Point u;
    for (int i = 0; i < 3; ++i) u[static_cast<std::size_t>(i)] = 0.01 * test::rough(x, i, 7);
    if (x[0] > between) {
      u[0] -= closer + 0.06 * (x[1] - 0.5) - 0.03 * x[2];
      u[1] += 0.13 + shift;
      u[2] -= 0.09;
    }
    return u;
  };
}

struct Sliding {
  Sliding(MPI_Comm of, const std::string& file, const DragCase& c)
      : solid(of, file, c.order, 2),
        bodies(test::touching(solid, between, test::barrier(7e4, 0.1), c.update)),
        friction(make_body_friction(bodies, {0.7, 0.05, stick_velocity}, {0.3}, c.update)),
        damping(make_body_damping(bodies, {0.3}, c.update)),
        potential(solid.layout(), solid.pattern(), {friction.get(), damping.get()}, solid.nothing_prescribed()),
        stage(solid, 0.0, dt, near_by(0.21, 0.0)),
        frozen(solid.vector(near_by(0.22, 0.01))) {
    potential.begin_stage(stage.point);
    potential.freeze(frozen.get());
  }
  Handle<Vec> gradient(Vec q) {
    Handle<Vec> r = potential.make_vector();
    potential.gradient(q, r.get());
    return r;
  }

  Solid solid;
  std::shared_ptr<const TouchingBodies> bodies;
  std::unique_ptr<EnergyTerm> friction, damping;
  IncrementalPotential potential;
  TestStage stage;
  Handle<Vec> frozen;
};

class BodyDrag : public ::testing::TestWithParam<DragCase> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
};

INSTANTIATE_TEST_SUITE_P(Every, BodyDrag,
                         ::testing::Values(DragCase{1, FrictionUpdate::frozen}, DragCase{1, FrictionUpdate::iterated},
                                           DragCase{2, FrictionUpdate::iterated}));

/// At rest relative to each other, creeping below the velocity of sticking, and slipping.
constexpr std::array shifts{0.0, 0.01, 0.2};

TEST_P(BodyDrag, DerivativesAreThoseOfTheValue) {
  Sliding at(comm, file_, GetParam());
  const Handle<Mat> K = at.potential.make_hessian();
  const Handle<Vec> d = at.solid.vector(test::rough_field(1.0, 3)), y = at.potential.make_vector();
  for (const double shift : shifts) {
    const Handle<Vec> q = at.solid.vector(near_by(0.215, shift)), r = at.gradient(q.get());
    constexpr double h = 1e-6;
    const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
    const double slope = (at.potential.value(ahead.get()) - at.potential.value(behind.get())) / (2.0 * h);
    EXPECT_GT(test::norm(r.get()), 0.0);
    EXPECT_NEAR(test::dot(r.get(), d.get()), slope, 1e-6 * test::norm(r.get())) << shift;
    at.potential.hessian(q.get(), K.get(), Projection::none);
    check(MatMult(K.get(), d.get(), y.get()));
    const Handle<Vec> after = at.gradient(ahead.get()), before = at.gradient(behind.get());
    check(VecAXPY(after.get(), -1.0, before.get()));
    check(VecScale(after.get(), 0.5 / h));
    EXPECT_LT(test::distance(y.get(), after.get()), 1e-6 * test::norm(y.get())) << shift;
  }
}

TEST_P(BodyDrag, ForcesBalanceAndDissipate) {
  Sliding at(comm, file_, GetParam());
  for (const double shift : shifts) {
    const Handle<Vec> q = at.solid.vector(near_by(0.215, shift)), r = at.gradient(q.get());
    const auto total = test::resultant(at.solid, r.get(), q.get());
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(total.force[i], 0.0, 1e-13 * test::norm(r.get()));
    if (shift > 0.0) {
      const auto power = at.potential.accounts().powers(q.get(), at.stage.v0.get(), at.potential.make_vector().get());
      EXPECT_GT(power[0].dissipated, 0.0);
      EXPECT_GE(power[1].dissipated, 0.0);
    }
  }
}

TEST_P(BodyDrag, NumbersAreThoseOfOneRank) {
  Sliding many(comm, file_, GetParam()), alone(MPI_COMM_SELF, file_, GetParam());
  const Handle<Mat> K = many.potential.make_hessian(), K_alone = alone.potential.make_hessian();
  const auto numbers_of = [](Sliding& at, Mat hessian, double shift) {
    const Handle<Vec> q = at.solid.vector(near_by(0.215, shift)), d = at.solid.vector(test::rough_field(1.0, 5)),
                      e = at.solid.vector(test::rough_field(1.0, 6)), r = at.gradient(q.get()),
                      y = at.potential.make_vector();
    at.potential.hessian(q.get(), hessian, Projection::none);
    check(MatMult(hessian, d.get(), y.get()));
    const auto powers = at.potential.accounts().powers(q.get(), d.get(), r.get());
    return std::array{at.potential.value(q.get()), test::dot(r.get(), d.get()), test::norm(r.get()),
                      test::dot(y.get(), e.get()), powers[0].dissipated,        powers[1].dissipated};
  };
  for (const double shift : shifts) {
    const auto here = numbers_of(many, K.get(), shift), there = numbers_of(alone, K_alone.get(), shift);
    for (std::size_t i = 0; i < here.size(); ++i) {
      EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-11) << shift << " " << i;
    }
  }
}

// Frozen coefficients hold where they were frozen, however far the bodies have moved on.
TEST_P(BodyDrag, HoldsWhereItIsFrozen) {
  Sliding at(comm, file_, GetParam());
  const Handle<Vec> q = at.solid.vector(near_by(0.215, 0.2));
  const double value = at.potential.value(q.get());
  const Handle<Vec> away = at.solid.vector(near_by(-5.0, 0.2));
  at.potential.value(away.get());
  EXPECT_EQ(at.potential.value(q.get()), value);
  EXPECT_GT(at.potential.value(away.get()), 0.0);
}

}  // namespace
}  // namespace pliant::test_body_drag
