// Tendons: derivatives, the same numbers on every number of ranks, slack, the capstan equation.
#include "energy/load/tendon_friction.hpp"
#include "energy/two_bodies.hpp"

#include <string>

namespace pliant::test_tendon {
namespace {

using test::Solid;
using test::TwoBodies;
using test::TwoBodiesFile;

const MPI_Comm comm = MPI_COMM_WORLD;

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
TwoBodies::Terms terms_of(const Solid& solid, const TendonCase& c) {
  std::vector<AttachedPoint> points;
  for (const std::array<double, 3>& X : {std::array{0.2, 0.3, 0.4}, {0.8, 0.6, 0.5}}) {
    points.push_back({locate(solid.layout(), X), {}});
  }
  points.push_back({{}, Vector3<double>{1.2, 0.9, 1.4}});
  for (const std::array<double, 3>& X : {std::array{1.5, 0.3, 0.6}, {2.1, 0.7, 0.3}}) {
    points.push_back({locate(solid.layout(), X), {}});
  }
  const bool rubs = c.friction.acts();
  const auto path = std::make_shared<TendonPath>(solid.layout(), points,
                                                 rubs ? TendonPath::Couples::all : TendonPath::Couples::neighbours);
  TwoBodies::Terms terms;
  terms.push_back(std::make_unique<Tendon>(path, c.drive));
  if (rubs) terms.push_back(std::make_unique<TendonFriction>(path, c.drive, c.friction));
  return terms;
}

class Tendons : public ::testing::TestWithParam<TendonCase> {
 protected:
  static TwoBodies::Terms make(const Solid& solid) { return terms_of(solid, GetParam()); }
  TwoBodiesFile file_;
};

INSTANTIATE_TEST_SUITE_P(Kinds, Tendons, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(Tendons, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(comm, file_.name, make);
  if (!GetParam().is_slack) return test::expect_derivatives(bodies);
  const auto q = bodies.place();
  const Handle<Vec> r = bodies.potential->make_vector();
  bodies.potential->gradient(q.get(), r.get());
  EXPECT_EQ(test::norm(r.get()), 0.0);
  EXPECT_EQ(bodies.potential->value(q.get()), 0.0);
}

TEST_P(Tendons, AreThoseOfOneRank) {
  test::expect_numbers_of_one_rank(file_.name, make);
}

// What friction takes from the motion is what it dissipates, and never negative.
TEST_P(Tendons, FrictionDissipatesWhatItTakes) {
  if (!GetParam().friction.acts()) return;
  TwoBodies bodies(comm, file_.name, make);
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
