// Tendons: derivatives, the same numbers on every number of ranks, slack, the capstan equation.
#include "energy/equation/incremental_potential.hpp"
#include "energy/load/tendon_friction.hpp"
#include "energy/near_springs.hpp"
#include "petsc/collective.hpp"

#include <numbers>
#include <optional>
#include <string>

namespace pliant::test_tendon {
namespace {

using test::Point;
using test::Scratch;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.3;

struct TendonCase {
  std::string name;
  TendonDrive drive;
  Friction friction = {};
  bool is_slack = false;
};

std::ostream& operator<<(std::ostream& out, const TendonCase& c) {
  return out << c.name;
}

std::vector<TendonCase> every_case() {
  const TendonDrive force = GivenTension{Expression("3+t")}, spring = TendonSpring{40.0, Expression("0.3+0.5*t")};
  return {{"Force", force},
          {"Spring", spring},
          {"SlackSpring", TendonSpring{40.0, Expression(-1.0)}, {}, true},
          {"SlidingForce", force, {0.4, 0.0, 0.01}},
          {"StickingForce", force, {0.4, 0.0, 30.0}},
          {"SlidingSpring", spring, {0.4, 0.0, 0.01}},
          {"StickingSpring", spring, {0.4, 0.0, 30.0}}};
}

/// A tendon through two bodies, and over a place in space between them.
struct TwoBodies {
  TwoBodies(MPI_Comm of, const std::string& file, const TendonCase& c) : solid(of, file, 1, 1) {
    const std::vector<std::array<double, 3>> places{
        {0.2, 0.3, 0.4}, {0.8, 0.6, 0.5}, {}, {1.5, 0.3, 0.6}, {2.1, 0.7, 0.3}};
    std::vector<AttachedPoint> points;
    for (const auto& X : places) {
      if (X == std::array<double, 3>{}) {
        points.push_back({{}, Vector3<double>{1.2, 0.9, 1.4}});
      } else {
        points.push_back({locate(solid.layout(), X), {}});
      }
    }
    const bool rubs = c.friction.acts();
    const auto path = std::make_shared<TendonPath>(solid.layout(), points,
                                                   rubs ? TendonPath::Couples::all : TendonPath::Couples::neighbours);
    terms.push_back(std::make_unique<Tendon>(path, c.drive));
    if (rubs) terms.push_back(std::make_unique<TendonFriction>(path, c.drive, c.friction));
    std::vector<const EnergyTerm*> all;
    for (const auto& term : terms) all.push_back(term.get());
    potential.emplace(solid.layout(), solid.pattern(), all, solid.nothing_prescribed());
    stage.emplace(solid, 0.3, 0.05, test::rough_field(0.02, 3), test::rough_field(0.3, 4));
    potential->begin_stage(stage->point);
    const auto q = place();
    potential->freeze(q.get());
  }
  Handle<Vec> place() const {
    return solid.vector([](const Point& x) {
      Point u;
      for (int i = 0; i < 3; ++i) u[static_cast<std::size_t>(i)] = 0.05 * test::rough(x, i, 7);
      return u;
    });
  }

  Solid solid;
  std::vector<std::unique_ptr<EnergyTerm>> terms;
  std::optional<IncrementalPotential> potential;
  std::optional<TestStage> stage;
};

class Tendons : public ::testing::TestWithParam<TendonCase> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
};

INSTANTIATE_TEST_SUITE_P(Kinds, Tendons, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(Tendons, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(comm, file_, GetParam());
  IncrementalPotential& potential = *bodies.potential;
  const auto q = bodies.place(), d = bodies.solid.vector(test::rough_field(1.0, 5));
  const Handle<Vec> r = potential.make_vector(), before = potential.make_vector(), after = potential.make_vector();
  constexpr double h = 1e-6;
  const auto ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
  potential.gradient(q.get(), r.get());
  if (GetParam().is_slack) {
    EXPECT_EQ(test::norm(r.get()), 0.0);
    EXPECT_EQ(potential.value(q.get()), 0.0);
    return;
  }
  ASSERT_GT(test::norm(r.get()), 0.01);
  EXPECT_NEAR(test::dot(r.get(), d.get()), (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h),
              1e-6 * test::norm(r.get()));
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q.get(), K.get(), Projection::none);
  Handle<Vec> y = potential.make_vector();
  check(MatMult(K.get(), d.get(), y.get()));
  std::vector<RankOne> parts;
  for (std::size_t k = 0; k < potential.num_rank_one(); ++k) parts.push_back({0.0, potential.make_vector()});
  potential.rank_one_parts(q.get(), parts);
  for (const RankOne& part : parts) check(VecAXPY(y.get(), part.c * test::dot(part.g.get(), d.get()), part.g.get()));
  potential.gradient(ahead.get(), after.get());
  potential.gradient(behind.get(), before.get());
  check(VecAXPY(after.get(), -1.0, before.get()));
  check(VecScale(after.get(), 1.0 / (2.0 * h)));
  EXPECT_LT(test::distance(y.get(), after.get()), 1e-6 * test::norm(y.get()));
}

TEST_P(Tendons, AreThoseOfOneRank) {
  TwoBodies many(comm, file_, GetParam()), alone(MPI_COMM_SELF, file_, GetParam());
  const auto numbers_of = [](TwoBodies& bodies) {
    const auto q = bodies.place(), d = bodies.solid.vector(test::rough_field(1.0, 5));
    const Handle<Vec> r = bodies.potential->make_vector();
    const auto powers = bodies.potential->accounts().powers(q.get(), d.get(), r.get());
    const auto energies = bodies.potential->accounts().energies({0.3, 1.0, nullptr}, q.get(), nullptr);
    return std::array{bodies.potential->value(q.get()), test::dot(r.get(), d.get()), test::norm(r.get()),
                      powers.front().supplied,          powers.back().dissipated,    energies.front()};
  };
  const auto here = numbers_of(many), there = numbers_of(alone);
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-14) << i;
  }
}

// What friction takes from the motion is what it dissipates, and never negative.
TEST_P(Tendons, FrictionDissipatesWhatItTakes) {
  if (!GetParam().friction.acts()) return;
  TwoBodies bodies(comm, file_, GetParam());
  for (const double amount : {1.0, -1.0, 0.01}) {
    const Handle<Vec> q = bodies.place(), r = bodies.potential->make_vector(), v = bodies.potential->make_vector();
    check(VecAXPBY(q.get(), 1.0 - amount, amount, bodies.stage->point.q0));
    check(VecWAXPY(v.get(), -1.0, bodies.stage->point.q0, q.get()));
    check(VecScale(v.get(), 1.0 / bodies.stage->point.dt));
    bodies.potential->freeze(q.get());
    const TermPower power = bodies.potential->accounts().powers(q.get(), v.get(), r.get()).back();
    EXPECT_GT(power.dissipated, 0.0);
    EXPECT_NEAR(-power.exerted, power.dissipated, 1e-11 * power.dissipated);
  }
}

}  // namespace
}  // namespace pliant::test_tendon
