// Springs and dampers between points: derivatives, opposite forces, coinciding points, the same numbers on every number
// of ranks.
#include "energy/load/spring.hpp"
#include "energy/two_bodies.hpp"

#include <memory>
#include <string>

namespace pliant::test_spring {
namespace {

using test::Point;
using test::Solid;
using test::TestStage;
using test::TwoBodies;
using test::TwoBodiesFile;

const MPI_Comm comm = MPI_COMM_WORLD;

enum class Kind { spring, damper };

struct SpringCase {
  std::string name;
  Kind kind;
  LineSpring law;
  std::vector<std::array<Point, 2>> lines;
  bool is_first_in_space = false;
};

std::ostream& operator<<(std::ostream& out, const SpringCase& c) {
  return out << c.name;
}

const std::array<Point, 2> across{{{0.8, 0.3, 0.6}, {1.6, 0.4, 0.2}}};
const std::array<Point, 2> within{{{0.1, 0.2, 0.3}, {0.7, 0.9, 0.6}}};
const std::array<Point, 2> in_a_cell{{{0.1, 0.15, 0.2}, {0.12, 0.2, 0.31}}};
const std::array<Point, 2> from_space{{{0.5, -1.0, 2.0}, {1.7, 0.8, 0.9}}};

std::vector<SpringCase> every_case() {
  const LineSpring stretched{30.0, 0.5, 0.0, false}, pushed{30.0, 1.5, 0.0, false}, taut{30.0, 0.5, 0.0, true},
      without_rest{30.0, 0.0, 0.0, false}, damper{0.0, 0.9, 3.0, false};
  const std::vector several{across, within, std::array<Point, 2>{across[1], within[0]}};
  return {{"Stretched", Kind::spring, stretched, {across}},
          {"Pushed", Kind::spring, pushed, {across}},
          {"Taut", Kind::spring, taut, {across}},
          {"WithoutRest", Kind::spring, without_rest, {across}},
          {"InOneBody", Kind::spring, stretched, {within}},
          {"InOneCell", Kind::spring, stretched, {in_a_cell}},
          {"Several", Kind::spring, stretched, several},
          {"ToSpace", Kind::spring, stretched, {from_space}, true},
          {"Damper", Kind::damper, damper, {across}},
          {"SeveralDampers", Kind::damper, damper, several},
          {"DamperToSpace", Kind::damper, damper, {from_space}, true}};
}

std::unique_ptr<LineTerm> term_of(const Solid& solid, const SpringCase& c) {
  std::vector<AttachedPoint> points;
  for (const auto& [first, second] : c.lines) {
    points.push_back(c.is_first_in_space ? AttachedPoint{{}, Vector3<double>(first)}
                                         : AttachedPoint{locate(solid.layout(), first), {}});
    points.push_back({locate(solid.layout(), second), {}});
  }
  std::vector<LineSpring> laws(c.lines.size(), c.law);
  if (c.kind == Kind::damper) return std::make_unique<Dampers>(solid.layout(), points, std::move(laws));
  return std::make_unique<Springs>(solid.layout(), points, std::move(laws));
}

class SpringTerms : public ::testing::TestWithParam<SpringCase> {
 protected:
  static TwoBodies::Terms make(const Solid& solid) {
    TwoBodies::Terms terms;
    terms.push_back(term_of(solid, GetParam()));
    return terms;
  }
  TwoBodiesFile file_;
};

INSTANTIATE_TEST_SUITE_P(Laws, SpringTerms, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return of.param.name; });

TEST_P(SpringTerms, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(comm, file_.name, make);
  EXPECT_EQ(bodies.potential->is_potential(), GetParam().kind == Kind::spring);
  test::expect_derivatives(bodies);
}

TEST_P(SpringTerms, ProjectedHessiansAreNotNegative) {
  TwoBodies bodies(comm, file_.name, make);
  const auto q = bodies.place();
  const Handle<Mat> K = bodies.potential->make_hessian();
  bodies.potential->hessian(q.get(), K.get(), Projection::positive_semidefinite);
  const Handle<Vec> y = bodies.potential->make_vector();
  for (int seed = 5; seed < 25; ++seed) {
    const auto d = bodies.solid.vector(test::rough_field(1.0, seed));
    check(MatMult(K.get(), d.get(), y.get()));
    EXPECT_GE(test::dot(y.get(), d.get()), -1e-12 * test::norm(y.get()));
  }
}

// What pulls at one point pulls back at the other.
TEST_P(SpringTerms, HaveNoResultant) {
  if (GetParam().is_first_in_space) return;
  TwoBodies bodies(comm, file_.name, make);
  test::expect_no_resultant(bodies);
}

TEST_P(SpringTerms, AreThoseOfOneRank) {
  test::expect_numbers_of_one_rank(file_.name, make);
}

/// The norms of gradient and Hessian of a term at rest.
std::array<double, 2> norms_at_rest(const std::string& file, const SpringCase& c) {
  const Solid solid(comm, file, 1, 1);
  const auto term = term_of(solid, c);
  IncrementalPotential potential(solid.layout(), solid.pattern(), {term.get()}, solid.nothing_prescribed());
  const TestStage stage(solid, 0.3, 0.05, test::rough_field(0.02, 3), test::rough_field(0.3, 4));
  potential.begin_stage(stage.point);
  const auto q = solid.vector([](const Point&) { return Point{}; });
  const Handle<Vec> r = potential.make_vector();
  const Handle<Mat> K = potential.make_hessian();
  potential.gradient(q.get(), r.get());
  potential.hessian(q.get(), K.get(), Projection::none);
  PetscReal size = 0.0;
  check(MatNorm(K.get(), NORM_FROBENIUS, &size));
  EXPECT_TRUE(std::isfinite(potential.value(q.get())));
  return {test::norm(r.get()), size};
}

class SpringsAtTheirLimits : public ::testing::Test {
 protected:
  TwoBodiesFile file_;
};

TEST_F(SpringsAtTheirLimits, CoincidingPointsHaveNoForce) {
  const std::array<Point, 2> same{across[0], across[0]};
  for (const double rest : {0.0, 0.2}) {
    for (const Kind kind : {Kind::spring, Kind::damper}) {
      const auto [force, stiffness] = norms_at_rest(file_.name, {"Same", kind, {30.0, rest, 3.0, false}, {same}});
      EXPECT_NEAR(force, 0.0, 1e-12);
      EXPECT_TRUE(std::isfinite(stiffness));
    }
  }
}

TEST_F(SpringsAtTheirLimits, SlackOnesDoNothing) {
  const auto [force, stiffness] = norms_at_rest(file_.name, {"Slack", Kind::spring, {30.0, 2.0, 0.0, true}, {across}});
  EXPECT_EQ(force, 0.0);
  EXPECT_EQ(stiffness, 0.0);
}

TEST(LineSprings, ForceIsThatOfSpringAndDamper) {
  const LineSpring spring{20.0, 1.5, 3.0, false}, string{20.0, 1.5, 0.0, true};
  EXPECT_DOUBLE_EQ(spring.force({0.0, 2.0, 0.0}, {7.0, 0.5, 0.0}), 20.0 * 0.5 + 3.0 * 0.5);
  EXPECT_DOUBLE_EQ(spring.force({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}), -20.0 * 0.5);
  EXPECT_EQ(string.force({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}), 0.0);
}

}  // namespace
}  // namespace pliant::test_spring
