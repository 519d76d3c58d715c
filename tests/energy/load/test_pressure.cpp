// Follower pressure: resultants in closed form, and what closed surfaces must fulfil.
#include "energy/load/pressure.hpp"
#include "energy/solid.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"

namespace pliant::test_pressure {
namespace {

using test::BodySpec;
using test::Field;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Volume of the moved body, from its cells.
template <int Order>
double volume(const NodeLayout& layout, std::span<const double> q) {
  const auto rule = simplex_rule<3>(3 * (Order - 1));
  double mine = 0.0;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    for (int p = 0; p < rule.size(); ++p) {
      const auto dN = Tet<Order>::gradients(rule.points[p]);
      Tensor3<double> columns{};
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (int i = 0; i < 3; ++i) {
          const double x = layout.position(nodes[a])[i] + q[3 * nodes[a] + i];
          for (int k = 0; k < 3; ++k) columns(i, k) += x * dN[a][k];
        }
      }
      mine += rule.weights[p] * det(columns);
    }
  }
  return sum(layout.comm, mine);
}

class Pressure : public ::testing::TestWithParam<BodySpec> {
 protected:
  double volume_at(Vec q) const {
    const auto u = test::local_values(q);
    return GetParam().order == 1 ? volume<1>(solid_.layout(), u) : volume<2>(solid_.layout(), u);
  }
  std::unique_ptr<FollowerPressure> on_the_whole_surface(const Expression& p) const {
    auto facets = surface_facets(solid_.mesh(), solid_.layout(), [](const Point&) { return true; });
    return std::make_unique<FollowerPressure>(solid_.layout(), solid_.pattern(), std::move(facets), p, Rim::none);
  }
  IncrementalPotential equation(const EnergyTerm& term) const {
    return {solid_.layout(), solid_.pattern(), {&term}, solid_.nothing_prescribed()};
  }
  /// The nodal forces at q.
  Handle<Vec> forces(const EnergyTerm& term, const TestStage& stage, Vec q) const {
    auto of = equation(term);
    of.begin_stage(stage.point);
    Handle<Vec> r = of.make_vector();
    of.gradient(q, r.get());
    check(VecScale(r.get(), -1.0));
    return r;
  }
  /// Power of the forces on a field of velocities.
  double power(Vec f, const Field& velocity) const { return test::dot(f, solid_.vector(velocity).get()); }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam()); });
  Solid solid_{comm, file_, GetParam().order, 2};
  bool is_curved_ = GetParam().shape == Shape::curved;
};

INSTANTIATE_TEST_SUITE_P(Bodies, Pressure,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::jittered, 2},
                                           BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

// On a plane of area A with normal e_x, moved by x = F X: -p cof(F) e_x A, whatever the mesh.
TEST_P(Pressure, OnAFlatPlateItIsPressureTimesAreaAlongTheNormal) {
  if (is_curved_) return;
  const auto term = solid_.pressure(Expression("3*t"));
  TestStage stage(solid_, 2.0, 0.1);
  stage.point.load_factor = 0.5;
  const Tensor3<double> F{{1.1, 0.2, -0.1, 0.3, 0.9, 0.05, -0.2, 0.1, 1.3}}, C = cofactor(F);
  const auto q = solid_.vector([&](const Point& X) {
    Point u{};
    for (int i = 0; i < 3; ++i) u[i] = F(i, 0) * X[0] + F(i, 1) * X[1] + F(i, 2) * X[2] - X[i];
    return u;
  });
  const auto f = forces(*term, stage, q.get());
  for (int i = 0; i < 3; ++i) {
    const auto along = [i](const Point&) {
      Point e{};
      e[i] = 1.0;
      return e;
    };
    EXPECT_NEAR(power(f.get(), along), -3.0 * C(i, 0), 1e-13);
  }
}

// A cubic over the face, which the rule for pressures in space holds; the resultant and its moment about the y axis.
TEST_P(Pressure, PressureInSpaceIsIntegrated) {
  if (is_curved_) return;
  const auto term = solid_.pressure(Expression("t*y*z^2"));
  const TestStage stage(solid_, 2.0, 0.1);
  const auto f = forces(*term, stage, solid_.vector(test::at_rest).get());
  EXPECT_NEAR(power(f.get(), [](const Point&) { return Point{1.0, 0.0, 0.0}; }), -2.0 / 6.0, 1e-13);
  EXPECT_NEAR(power(f.get(), [](const Point& X) { return Point{X[2], 0.0, 0.0}; }), -2.0 / 8.0, 1e-13);
}

// Closed surface: no resultant force, no moment, in any state; and the work on any motion is -p dV.
TEST_P(Pressure, OnAClosedSurfaceItWorksOnTheVolumeAlone) {
  const double p = 7.0;
  const auto term = on_the_whole_surface(Expression(p));
  const TestStage stage(solid_, 0.0, 0.1);
  const auto q = solid_.vector(test::strained);
  const auto f = forces(*term, stage, q.get());
  const double size = test::norm(f.get());
  ASSERT_GT(size, 1.0);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const auto translation = [i](const Point&) {
      Point e{};
      e[i] = 1.0;
      return e;
    };
    const auto rotation = [j, k](const Point& X) {
      const Point u = test::strained(X);
      Point w{};
      w[j] = -(X[k] + u[k]);
      w[k] = X[j] + u[j];
      return w;
    };
    EXPECT_NEAR(power(f.get(), translation), 0.0, 1e-13 * size);
    EXPECT_NEAR(power(f.get(), rotation), 0.0, 1e-13 * size);
  }
  const auto d = solid_.vector(test::rough_field(0.05, 11));
  const auto at = [&](double alpha) { return volume_at(test::moved(q.get(), alpha, d.get()).get()); };
  // V is a cubic in q: the difference of fourth order is exact, up to its rounding.
  constexpr double h = 0.5;
  const double dV = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
  ASSERT_GT(std::abs(dV), 1e-5);
  EXPECT_NEAR(test::dot(f.get(), d.get()), -p * dV, 1e-12 * p);
}

// There p V is a potential, so K is symmetric, although its facets' parts are not.
TEST_P(Pressure, OnAClosedSurfaceItsTangentIsSymmetric) {
  const auto term = on_the_whole_surface(Expression(1.0));
  auto of = equation(*term);
  const TestStage stage(solid_, 0.0, 0.1);
  of.begin_stage(stage.point);
  const Handle<Mat> K = of.make_hessian();
  of.hessian(solid_.vector(test::strained).get(), K.get(), Projection::none);
  const auto a = solid_.vector(test::rough_field(1.0, 1)), b = solid_.vector(test::rough_field(1.0, 2));
  const Handle<Vec> Ka = of.make_vector(), Kb = of.make_vector();
  check(MatMult(K.get(), a.get(), Ka.get()));
  check(MatMult(K.get(), b.get(), Kb.get()));
  ASSERT_GT(test::norm(Ka.get()), 0.1);
  EXPECT_NEAR(test::dot(b.get(), Ka.get()), test::dot(a.get(), Kb.get()),
              1e-13 * test::norm(Ka.get()) * test::norm(b.get()));
}

// Its potential is p times the volume that the surface has swept.
TEST_P(Pressure, OnAClosedSurfaceItHasAPotential) {
  const auto term = on_the_whole_surface(Expression(7.0));
  EXPECT_TRUE(term->declaration().is_potential);
  EXPECT_EQ(term->declaration().symmetry, Symmetry::symmetric);
  EXPECT_EQ(term->declaration().account, Account::load_potential);
  auto of = equation(*term);
  const TestStage stage(solid_, 0.0, 0.1, test::rough_field(0.01, 3));
  of.begin_stage(stage.point);
  const auto q = solid_.vector(test::strained);
  const double V = volume_at(q.get()), V0 = volume_at(stage.q0.get()), V_rest = GetParam().volume();
  EXPECT_NEAR(of.value(q.get()), 7.0 * (V - V0), 1e-13);
  EXPECT_NEAR(of.accounts().energies({}, q.get(), nullptr)[0], 7.0 * (V - V_rest), 1e-12);
  EXPECT_EQ(on_the_whole_surface(Expression("t"))->declaration().account, Account::load);
  EXPECT_FALSE(on_the_whole_surface(Expression("1+x"))->declaration().is_potential);
}

// The work from one state to another does not depend on the way where the rim slides in its plane, and does where it
// leaves it.
TEST(PressureWithARim, HasAPotentialWhereTheRimStaysInItsPlane) {
  for (const int order : {1, 2}) {
    const Scratch scratch(comm);
    const auto file = scratch.file("body.msh", [&](const std::string& f) {
      test::write_body(f, {order, Shape::jittered, 3});
    });
    const Solid solid(comm, file, order, 2);
    const auto facets =
        surface_facets(solid.mesh(), solid.layout(), [](const Point& x) { return std::abs(x[0] - 1.0) < 1e-9; });
    const FollowerPressure term(solid.layout(), solid.pattern(), facets, Expression(7.0), Rim::still);
    EXPECT_TRUE(term.declaration().is_potential);
    const auto excess_of_a_detour = [&](double out_of_plane) {
      const auto state = [&](int seed) {
        return test::local_values(solid
                                      .vector([=](const Point& x) {
                                        Point u = test::rough_field(0.1, seed)(x);
                                        const bool is_on_rim = std::min({x[1], x[2], 1.0 - x[1], 1.0 - x[2]}) < 1e-9;
                                        if (is_on_rim) u[0] *= out_of_plane;
                                        return u;
                                      })
                                      .get());
      };
      const std::array q{state(1), state(2), state(3)};
      const auto work = [&](int from, int to) {
        LocalStage stage;
        stage.q0 = q[from];
        return term.value(stage, q[to]);
      };
      return std::abs(sum(comm, work(0, 1) + work(1, 2) + work(2, 0)));
    };
    EXPECT_LE(excess_of_a_detour(0.0), 1e-14);
    EXPECT_GE(excess_of_a_detour(1.0), 1e-4);
  }
}

TEST_P(Pressure, DeclaresItselfALoadWithoutPotential) {
  const auto term = solid_.pressure(Expression(1.0));
  const auto of = equation(*term);
  EXPECT_EQ(of.non_potentials(), std::vector<std::string>{"pressure"});
  EXPECT_EQ(of.symmetry(), Symmetry::unsymmetric);
  EXPECT_EQ(term->declaration().account, Account::load);
}

}  // namespace
}  // namespace pliant::test_pressure
