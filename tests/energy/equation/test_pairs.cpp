// Terms that couple pairs: derivatives while the set of pairs changes, and the same numbers on every number of ranks.
#include "energy/equation/constrained_equation.hpp"
#include "energy/near_springs.hpp"
#include "petsc/collective.hpp"

#include <optional>

namespace pliant::test_pairs {
namespace {

using test::NearSprings;
using test::Point;
using test::Scratch;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.3, reach = 0.45, stiffness = 700.0, between = 1.0 + 0.5 * gap;

/// The second body comes nearer, by `closer`, and is turned a little; both are strained from node to node.
test::Field approach(double closer) {
  return [closer](const Point& x) {
    const bool moves = x[0] > between;
    Point u;
    for (int i = 0; i < 3; ++i) u[static_cast<std::size_t>(i)] = 0.02 * test::rough(x, i, 7);
    if (moves) {
      u[0] -= closer + 0.1 * closer * x[1];
      u[1] += 0.3 * closer;
    }
    return u;
  };
}

/// Two bodies with elasticity and springs between them.
struct TwoBodies {
  TwoBodies(MPI_Comm of, const std::string& file, int order, bool is_held = true)
      : solid(of, file, order, 2),
        law(test::every_law()[0]),
        elastic(solid.elastic(law)),
        springs(solid.layout(), between, stiffness, reach),
        prescribed(solid.nothing_prescribed()) {
    for (PetscInt node = 0; node < solid.layout().num_local_nodes && is_held; ++node) {
      if (solid.layout().position(node)[0] > 1e-9 && solid.layout().position(node)[0] < 1.0 - 1e-9) continue;
      if (solid.layout().position(node)[1] < 0.6) prescribed[3 * static_cast<std::size_t>(node) + 1] = 1;
    }
    potential.emplace(solid.layout(), solid.pattern(), std::vector<const EnergyTerm*>{elastic.get(), &springs},
                      prescribed);
    stage.emplace(solid, 0.0, 0.1);
    potential->begin_stage(stage->point);
  }
  /// y = K(q) d for a displacement and a direction.
  Handle<Vec> product(Vec q, Vec d, Mat K) {
    potential->hessian(q, K, Projection::none);
    Handle<Vec> y = potential->make_vector();
    check(MatMult(K, d, y.get()));
    return y;
  }

  Solid solid;
  ElasticLawSpec law;
  std::unique_ptr<ElasticTerm> elastic;
  NearSprings springs;
  std::vector<char> prescribed;
  std::optional<IncrementalPotential> potential;
  std::optional<TestStage> stage;
};

class Pairs : public ::testing::TestWithParam<int> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
};

INSTANTIATE_TEST_SUITE_P(Order, Pairs, ::testing::Values(1, 2));

// The direction leads across the distances at which springs begin; one matrix takes all patterns.
TEST_P(Pairs, DerivativesHoldWhileTheSetOfPairsChanges) {
  TwoBodies bodies(comm, file_, GetParam());
  const Handle<Mat> K = bodies.potential->make_hessian();
  const Handle<Vec> d = bodies.solid.vector([&](const Point& x) {
    Point way = approach(1.0)(x);
    for (int i = 0; i < 3; ++i) way[static_cast<std::size_t>(i)] += test::rough(x, i, 3);
    return way;
  });
  {
    const ArrayView entries(d.get());
    for (PetscInt i = 0; i < 3 * bodies.solid.layout().num_owned_nodes; ++i) {
      if (bodies.prescribed[static_cast<std::size_t>(i)]) entries[i] = 0.0;
    }
  }
  const Handle<Vec> r = bodies.potential->make_vector(), before = bodies.potential->make_vector(),
                    after = bodies.potential->make_vector();
  double coupling = -1.0;
  for (const double closer : {0.0, 0.1, 0.25, -1.0, 0.2, 0.05}) {
    const Handle<Vec> q = bodies.solid.vector(approach(closer));
    constexpr double h = 1e-6;
    const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
    bodies.potential->gradient(q.get(), r.get());
    const double slope = test::dot(r.get(), d.get());
    const double difference =
        (bodies.potential->value(ahead.get()) - bodies.potential->value(behind.get())) / (2.0 * h);
    EXPECT_NEAR(slope, difference, 1e-6 * std::abs(slope)) << closer;

    const Handle<Vec> y = bodies.product(q.get(), d.get(), K.get());
    bodies.potential->gradient(ahead.get(), after.get());
    bodies.potential->gradient(behind.get(), before.get());
    check(VecAXPY(after.get(), -1.0, before.get()));
    check(VecScale(after.get(), 1.0 / (2.0 * h)));
    // Rows of prescribed entries hold the diagonal alone, and the direction is zero there.
    EXPECT_LT(test::distance(y.get(), after.get()), 1e-6 * test::norm(y.get())) << closer;
    EXPECT_GT(test::norm(y.get()), 0.0);
    // The springs act, but for the place that is far away.
    const double energy = bodies.potential->accounts().energies({}, q.get(), nullptr)[1];
    EXPECT_EQ(energy > 0.0, closer >= 0.0) << closer;
    EXPECT_NE(energy, coupling);
    coupling = energy;
  }
}

// A rank alone has all pairs in one place; with more of them they lie across the cut.
TEST_P(Pairs, NumbersAreThoseOfOneRank) {
  TwoBodies many(comm, file_, GetParam()), alone(MPI_COMM_SELF, file_, GetParam());
  const Handle<Mat> K = many.potential->make_hessian(), K_alone = alone.potential->make_hessian();
  const auto numbers_of = [](TwoBodies& bodies, Mat hessian, double closer) {
    const Handle<Vec> q = bodies.solid.vector(approach(closer)), d = bodies.solid.vector(test::rough_field(1.0, 5)),
                      e = bodies.solid.vector(test::rough_field(1.0, 6)), r = bodies.potential->make_vector();
    std::vector<double> numbers{bodies.potential->value(q.get()), bodies.potential->force_scale(q.get())};
    bodies.potential->gradient(q.get(), r.get());
    numbers.push_back(test::dot(r.get(), d.get()));
    numbers.push_back(test::norm(r.get()));
    const Handle<Vec> y = bodies.product(q.get(), d.get(), hessian);
    numbers.push_back(test::dot(y.get(), e.get()));
    numbers.push_back(test::norm(y.get()));
    numbers.push_back(bodies.potential->accounts().energies({}, q.get(), nullptr)[1]);
    numbers.push_back(bodies.potential->rounding_floor(q.get()));
    return numbers;
  };
  for (const double closer : {0.25, -1.0, 0.0, 0.2}) {
    const auto here = numbers_of(many, K.get(), closer), there = numbers_of(alone, K_alone.get(), closer);
    for (std::size_t i = 0; i < here.size(); ++i) {
      EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-11) << closer << " " << i;
    }
  }
}

// What was evaluated before decides which pairs are looked at, and must not show.
TEST_P(Pairs, WhatWasEvaluatedBeforeDoesNotShow) {
  TwoBodies fresh(comm, file_, GetParam()), used(comm, file_, GetParam());
  const Handle<Vec> q = fresh.solid.vector(approach(0.2));
  for (const double closer : {0.3, -2.0, 0.25, 0.1}) {
    const Handle<Vec> elsewhere = used.solid.vector(approach(closer));
    (void)used.potential->value(elsewhere.get());
  }
  EXPECT_DOUBLE_EQ(fresh.potential->value(q.get()), used.potential->value(q.get()));
  const Handle<Vec> r = fresh.potential->make_vector(), s = fresh.potential->make_vector();
  fresh.potential->gradient(q.get(), r.get());
  used.potential->gradient(q.get(), s.get());
  EXPECT_LE(test::distance(r.get(), s.get()), 1e-14 * test::norm(r.get()));
}

// Along a direction all pairs are there that are near anywhere on the way.
TEST_P(Pairs, MayBeMetAnywhereOnTheWay) {
  TwoBodies bodies(comm, file_, GetParam());
  const Handle<Vec> far = bodies.solid.vector(approach(-1.3)), near = bodies.solid.vector(approach(0.2));
  const Handle<Vec> d = test::moved(near.get(), -1.0, far.get());
  EXPECT_EQ(bodies.potential->max_step(far.get(), d.get()), std::numeric_limits<double>::infinity());
  // The pairs of the way hold at its end: the same energy as of one who comes from elsewhere.
  TwoBodies fresh(comm, file_, GetParam());
  EXPECT_DOUBLE_EQ(bodies.potential->value(near.get()), fresh.potential->value(near.get()));
}

// A direction that is too long to look for all pairs on the way bounds the step, by the same length however long it is
// and whatever was searched before.
TEST_P(Pairs, BoundTheStepAlongAHugeDirection) {
  TwoBodies bodies(comm, file_, GetParam()), used(comm, file_, GetParam());
  const Handle<Vec> q = bodies.solid.vector(approach(0.1));
  double length = 0.0;
  for (const double size : {1e3, 1e6, 1e12}) {
    const Handle<Vec> d = bodies.solid.vector(test::rough_field(size, 5));
    PetscReal longest = 0.0;
    check(VecNorm(d.get(), NORM_INFINITY, &longest));
    const double bound = bodies.potential->max_step(q.get(), d.get());
    EXPECT_GT(bound, 0.0);
    EXPECT_LT(bound, 1.0);
    EXPECT_GT(bound * longest, reach);
    if (length > 0.0) {
      EXPECT_NEAR(bound * longest, length, 1e-12 * length);
    }
    length = bound * longest;
    (void)used.potential->value(d.get());
    EXPECT_EQ(used.potential->max_step(q.get(), d.get()), bound);
    EXPECT_EQ(bodies.potential->max_step(q.get(), d.get()), bound);
    const Handle<Vec> end = test::moved(q.get(), 0.5 * bound, d.get());
    EXPECT_DOUBLE_EQ(bodies.potential->value(end.get()), used.potential->value(end.get()));
  }
}

}  // namespace
}  // namespace pliant::test_pairs
