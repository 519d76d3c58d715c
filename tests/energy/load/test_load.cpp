// Dead loads: their resultants in closed form.
#include "energy/load/load.hpp"
#include "energy/solid.hpp"

namespace pliant::test_load {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double density = 1200.0;

class Loads : public ::testing::TestWithParam<BodySpec> {
 protected:
  /// Sum of the nodal forces, and of their first moments sum_a f_a X_a[k].
  Point resultant(const DeadLoad& load, double time) const {
    const auto f = load.forces(time);
    Point total{};
    for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a) {
      for (int i = 0; i < 3; ++i) total[i] += f[3 * a + i];
    }
    for (double& t : total) t = sum(comm, t);
    return total;
  }
  double first_moment(const DeadLoad& load, int i, int k) const {
    const auto f = load.forces(0.0);
    double total = 0.0;
    for (PetscInt a = 0; a < solid_.layout().num_owned_nodes; ++a)
      total += f[3 * a + i] * solid_.layout().position(a)[k];
    return sum(comm, total);
  }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam()); });
  Solid solid_{comm, file_, GetParam().order, 2};
  bool is_curved_ = GetParam().shape == Shape::curved;
};

INSTANTIATE_TEST_SUITE_P(Bodies, Loads,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 2},
                                           BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Loads, GravityIsTheWeight) {
  const auto load = solid_.gravity(density, {Expression(), Expression(), Expression(-9.81)});
  EXPECT_FALSE(load->depends_on_time());
  const Point f = resultant(*load, 0.0);
  const double weight = 9.81 * density * GetParam().volume();
  EXPECT_EQ(f[0], 0.0);
  EXPECT_NEAR(f[2], -weight, 1e-12 * weight);
}

TEST_P(Loads, TractionIsItsDensityTimesTheArea) {
  if (is_curved_) return;
  const auto load = solid_.traction({Expression(5.0), Expression(-2.0), Expression("0.5*t")});
  EXPECT_TRUE(load->depends_on_time());
  const Point f = resultant(*load, 3.0);
  EXPECT_NEAR(f[0], 5.0, 1e-13);
  EXPECT_NEAR(f[1], -2.0, 1e-13);
  EXPECT_NEAR(f[2], 1.5, 1e-13);
  EXPECT_NEAR(first_moment(*load, 0, 1), 2.5, 1e-13);  // its line of action is through the face's middle
}

// Cubics in space, which the rules for loads in space hold on every element; t is a factor.
TEST_P(Loads, LoadsInSpaceAreIntegrated) {
  if (is_curved_) return;
  const auto body = solid_.gravity(density, {Expression("x^3"), Expression("x*y*z"), Expression("t*z^2*y")});
  const Point f = resultant(*body, 2.0);
  EXPECT_NEAR(f[0], density / 4.0, 1e-12 * density);
  EXPECT_NEAR(f[1], density / 8.0, 1e-12 * density);
  EXPECT_NEAR(f[2], density / 3.0, 1e-12 * density);
  const auto face = solid_.traction({Expression("y^3"), Expression("x*y*z^2"), Expression("t*y")});
  const Point g = resultant(*face, 2.0);
  EXPECT_NEAR(g[0], 1.0 / 4.0, 1e-13);
  EXPECT_NEAR(g[1], 1.0 / 6.0, 1e-13);
  EXPECT_NEAR(g[2], 1.0, 1e-13);
}

TEST_P(Loads, LineForceIsItsDensityTimesTheLength) {
  if (is_curved_) return;
  const auto load = solid_.line_force({Expression(5.0), Expression("3*x^2"), Expression("t*x")});
  const Point f = resultant(*load, 2.0);
  EXPECT_NEAR(f[0], 5.0, 1e-13);
  EXPECT_NEAR(f[1], 1.0, 1e-13);
  EXPECT_NEAR(f[2], 1.0, 1e-13);
  EXPECT_NEAR(first_moment(*load, 0, 0), 2.5, 1e-13);
}

// Whatever the area, the length and the number of nodes.
TEST_P(Loads, ATotalForceIsShared) {
  const std::array<Expression, 3> value{Expression(2.0), Expression("1-t"), Expression(-9.0)};
  const NodeLayout& layout = solid_.layout();
  const auto facets = facets_of_group(solid_.mesh(), layout, test::group_named(solid_.mesh(), "tip"));
  const auto edges = edges_of_group(solid_.mesh(), layout, test::group_named(solid_.mesh(), "edge"));
  const auto nodes = nodes_of_group(solid_.mesh(), layout, test::group_named(solid_.mesh(), "clamp"));
  for (const LoadSamples& samples :
       {with_total_weight_one(layout, facet_samples(layout, facets, Variation::uniform), facets.is_owned),
        with_total_weight_one(layout, edge_samples(layout, edges, Variation::uniform), edges.is_owned),
        with_total_weight_one(layout, node_samples(layout, nodes), std::vector<char>(nodes.size(), 1))}) {
    const Point f = resultant(DeadLoad(layout, samples, value), 3.0);
    EXPECT_NEAR(f[0], 2.0, 1e-13);
    EXPECT_NEAR(f[1], -2.0, 1e-13);
    EXPECT_NEAR(f[2], -9.0, 1e-13);
  }
}

// On a curved body too: the same load written as one that varies in space, by its own rule.
TEST_P(Loads, AUniformLoadIsTheSameHoweverItIsWritten) {
  const auto uniform = solid_.gravity(density, {Expression(1.0), Expression(2.0), Expression(3.0)});
  const auto varied = solid_.gravity(density, {Expression("1+0*x"), Expression("2+0*y"), Expression("3+0*t*z")});
  const auto f = uniform->forces(0.7), g = varied->forces(0.7);
  for (PetscInt i = 0; i < 3 * solid_.layout().num_owned_nodes; ++i) EXPECT_NEAR(f[i], g[i], 1e-13 * density);
}

TEST_P(Loads, WorkIsForceTimesDisplacementFromTheStart) {
  const auto load = solid_.gravity(density, {Expression("1+t"), Expression(), Expression(-9.81)});
  IncrementalPotential potential(solid_.layout(), solid_.pattern(), {load.get()}, solid_.nothing_prescribed());
  TestStage stage(solid_, 2.0, 0.1, [](const Point&) { return Point{4.0, 5.0, 6.0}; });
  const auto q = solid_.vector([](const Point&) { return Point{5.0, 7.0, 6.5}; });
  const double mass = density * GetParam().volume();
  for (const double factor : {1.0, 0.25}) {
    stage.point.load_factor = factor;
    potential.begin_stage(stage.point);
    EXPECT_NEAR(potential.value(q.get()), -factor * mass * (3.0 * 1.0 - 9.81 * 0.5), 1e-12 * mass);
  }
}

TEST_P(Loads, PartsWithoutFactorCarryNothing) {
  std::vector<double> factors(static_cast<std::size_t>(solid_.layout().num_local_cells), 0.0);
  const auto samples = cell_samples(solid_.layout(), factors, Variation::uniform);
  EXPECT_TRUE(samples.weights.empty());
  const DeadLoad load(solid_.layout(), samples, {Expression(1.0), Expression("x"), Expression()});
  for (const double f : load.forces(0.0)) EXPECT_EQ(f, 0.0);
}

}  // namespace
}  // namespace pliant::test_load
