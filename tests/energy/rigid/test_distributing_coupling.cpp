// Bodies that follow the mean motion of a surface: means of surfaces, derivatives, what is invariant and what is free,
// the same numbers on every number of ranks.
#include "energy/rigid/distributing_coupling.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "energy/two_bodies.hpp"
#include "time/rotation.hpp"

#include <cmath>
#include <memory>
#include <ostream>
#include <string>

namespace pliant::test_distributing_coupling {
namespace {

using test::Point;
using test::Solid;
using test::TwoBodies;
using test::TwoBodiesFile;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double stiffness = 40.0, tiny = 1e-9;

struct CouplingCase {
  std::string name;
  int order;
  bool is_plane;  // the face of the first cube that looks at the second, or two faces at right angles
};

std::ostream& operator<<(std::ostream& out, const CouplingCase& c) {
  return out << c.name;
}

bool is_of_first(const Point& x) {
  return x[0] < 1.0 + 0.5 * TwoBodies::gap;
}

FacetList surface_of(const Solid& solid, const CouplingCase& c) {
  FacetList facets =
      surface_facets(solid.mesh(), solid.layout(), [](const Point& x) { return is_of_first(x) && x[0] > 1.0 - tiny; });
  if (c.is_plane) return facets;
  const FacetList below =
      surface_facets(solid.mesh(), solid.layout(), [](const Point& x) { return is_of_first(x) && x[2] < tiny; });
  facets.nodes.insert(facets.nodes.end(), below.nodes.begin(), below.nodes.end());
  facets.is_owned.insert(facets.is_owned.end(), below.is_owned.begin(), below.is_owned.end());
  facets.is_outer.insert(facets.is_outer.end(), below.is_outer.begin(), below.is_outer.end());
  return facets;
}

/// A tetrahedron of the second cube stands for the rigid body.
JointBody body_of(const Solid& solid) {
  std::vector<int> body_of_cell;
  for (PetscInt cell = 0; cell < solid.layout().num_local_cells; ++cell) {
    body_of_cell.push_back(is_of_first(solid.layout().position(solid.layout().nodes_of_cell(cell)[0])) ? 0 : 1);
  }
  return joint_body(solid.layout(), body_of_cell, 1);
}

class DistributingCouplings : public ::testing::TestWithParam<CouplingCase> {
 protected:
  static TwoBodies::Terms make(const Solid& solid) {
    TwoBodies::Terms terms;
    terms.push_back(std::make_unique<DistributingCoupling>(
        solid.layout(), mean_of_surface(solid.layout(), surface_of(solid, GetParam())), body_of(solid), stiffness));
    return terms;
  }
  TwoBodies bodies() const { return TwoBodies(comm, file_.name, make, GetParam().order); }

  static double energy(TwoBodies& of, Vec q) {
    return of.potential->accounts().energies({0.3, 1.0, nullptr}, q, nullptr).front();
  }
  static double force(TwoBodies& of, Vec q) {
    const Handle<Vec> r = of.potential->make_vector();
    of.potential->gradient(q, r.get());
    return test::norm(r.get());
  }

  TwoBodiesFile file_;
};

INSTANTIATE_TEST_SUITE_P(Surfaces, DistributingCouplings,
                         ::testing::Values(CouplingCase{"PlaneP1", 1, true}, CouplingCase{"PlaneP2", 2, true},
                                           CouplingCase{"AngleP1", 1, false}, CouplingCase{"AngleP2", 2, false}),
                         [](const auto& of) { return of.param.name; });

// Means of quadratic polynomials on P2 elements, of linear ones on P1.
TEST_P(DistributingCouplings, MeansAreThoseOfTheSurface) {
  const Solid solid(comm, file_.name, GetParam().order, 1);
  const SurfaceMean mean = mean_of_surface(solid.layout(), surface_of(solid, GetParam()));
  const double area = GetParam().is_plane ? 1.0 : 2.0;
  EXPECT_NEAR(mean.area, area, 1e-13);
  const Point middle = GetParam().is_plane ? Point{1.0, 0.5, 0.5} : Point{0.75, 0.5, 0.25};
  // int (X - X_m)^2 dA / A of one face, or of two, each with half the area and its middle 1/4 away.
  const Point squares = GetParam().is_plane ? Point{0.0, 1.0 / 12.0, 1.0 / 12.0}
                                            : Point{1.0 / 24.0 + 1.0 / 16.0, 1.0 / 12.0, 1.0 / 24.0 + 1.0 / 16.0};
  std::array<double, 8> sums{};
  for (const NodeOfSurface& at : mean.nodes) {
    const Point x = solid.layout().position(at.node);
    sums[0] += at.share;
    for (std::size_t i = 0; i < 3; ++i) {
      sums[1 + i] += at.share * x[i];
      sums[4 + i] += at.moment[i] * x[i];
    }
    sums[7] += at.share * x[1] * x[1];
  }
  sum_in_place(comm, sums);
  EXPECT_NEAR(sums[0], 1.0, 1e-13);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean.middle[i], middle[i], 1e-13);
    EXPECT_NEAR(sums[1 + i], middle[i], 1e-13);
    EXPECT_NEAR(mean.second_moment(static_cast<int>(i), static_cast<int>(i)), squares[i], 1e-13);
    EXPECT_NEAR(sums[4 + i], squares[i], 1e-13);
  }
  if (GetParam().order == 2) {
    EXPECT_NEAR(sums[7], 1.0 / 3.0, 1e-13);
  }
  EXPECT_FALSE(mean.is_line());
}

TEST_P(DistributingCouplings, DerivativesAreThoseOfDifferences) {
  auto of = bodies();
  EXPECT_TRUE(of.potential->is_potential());
  test::expect_derivatives(of);
}

TEST_P(DistributingCouplings, ProjectedHessiansAreNotNegative) {
  auto of = bodies();
  const auto q = of.place();
  const Handle<Mat> K = of.potential->make_hessian();
  of.potential->hessian(q.get(), K.get(), Projection::positive_semidefinite);
  const Handle<Vec> y = of.potential->make_vector();
  for (int seed = 5; seed < 25; ++seed) {
    const auto d = of.solid.vector(test::rough_field(1.0, seed));
    check(MatMult(K.get(), d.get(), y.get()));
    EXPECT_GE(test::dot(y.get(), d.get()), -1e-12 * test::norm(y.get()));
  }
}

TEST_P(DistributingCouplings, HaveNoResultant) {
  auto of = bodies();
  test::expect_no_resultant(of);
}

TEST_P(DistributingCouplings, HaveNoMoment) {
  auto of = bodies();
  const auto q = of.place();
  const Handle<Vec> r = of.potential->make_vector();
  of.potential->gradient(q.get(), r.get());
  std::array<double, 3> total{};
  {
    const ConstArrayView f(r.get()), u(q.get());
    for (PetscInt n = 0; n < of.solid.layout().num_owned_nodes; ++n) {
      const Vector3<double> x =
          Vector3<double>(of.solid.layout().position(n)) + Vector3<double>{u[3 * n], u[3 * n + 1], u[3 * n + 2]};
      const auto moment = cross(x, Vector3<double>{f[3 * n], f[3 * n + 1], f[3 * n + 2]});
      for (std::size_t i = 0; i < 3; ++i) total[i] += moment[i];
    }
  }
  sum_in_place(comm, total);
  for (const double component : total) EXPECT_NEAR(component, 0.0, 1e-12 * test::norm(r.get()));
}

TEST_P(DistributingCouplings, AreThoseOfOneRank) {
  test::expect_numbers_of_one_rank(file_.name, make, GetParam().order);
}

const Placement somewhere{{3.0, -2.0, 1.0}, exponential(Vector3<double>{1.1, -0.7, 1.9})};

// From rest nothing acts, and from anywhere the energy stays.
TEST_P(DistributingCouplings, DoNotFeelCommonRigidMotions) {
  auto of = bodies();
  const auto moved = of.solid.vector([](const Point& x) { return somewhere.displacement(x); });
  EXPECT_LT(energy(of, moved.get()), 1e-26 * stiffness);
  EXPECT_LT(force(of, moved.get()), 1e-13 * stiffness);
  const auto q = of.place();
  const auto both = of.solid.vector([](const Point& x) {
    Vector3<double> at = x;
    for (int i = 0; i < 3; ++i) at[static_cast<std::size_t>(i)] += 0.05 * test::rough(x, i, 7);
    return somewhere.displacement(at) + at - Vector3<double>(x);
  });
  const double before = energy(of, q.get());
  ASSERT_GT(before, 1e-3);
  EXPECT_NEAR(energy(of, both.get()), before, 1e-12 * before);
  EXPECT_NEAR(force(of, both.get()), force(of, q.get()), 1e-12 * force(of, q.get()));
}

/// A field on the first cube, where the surface is; the second rests.
Handle<Vec> on_first(const TwoBodies& of, const std::function<Point(const Point&)>& field) {
  return of.solid.vector([&](const Point& x) { return is_of_first(x) ? field(x) : Point{}; });
}

TEST_P(DistributingCouplings, LetTheSurfaceStretchAndWarp) {
  if (!GetParam().is_plane) return;
  auto of = bodies();
  const auto stretched = on_first(of, [](const Point& x) {
    return Point{0.0, 0.3 * (x[1] - 0.5) + 0.1 * (x[2] - 0.5), -0.2 * (x[2] - 0.5) + 0.1 * (x[1] - 0.5)};
  });
  EXPECT_LT(energy(of, stretched.get()), 1e-26 * stiffness);
  EXPECT_LT(force(of, stretched.get()), 1e-13 * stiffness);
  // Odd in both directions: no mean, no turn.
  const auto warped = on_first(of, [](const Point& x) { return Point{(x[1] - 0.5) * (x[2] - 0.5), 0.0, 0.0}; });
  if (GetParam().order == 2) {
    EXPECT_LT(force(of, warped.get()), 1e-13 * stiffness);
  }
}

// k/2 d^2, and k/2 sin^2(angle) n . J_r n, J_r n = 1/6 n about the normal and 1/12 n across it.
TEST_P(DistributingCouplings, ResistOffsetsAndRotations) {
  if (!GetParam().is_plane) return;
  auto of = bodies();
  const auto offset = on_first(of, [](const Point&) { return Point{0.1, -0.2, 0.2}; });
  EXPECT_NEAR(energy(of, offset.get()), 0.5 * stiffness * 0.09, 1e-12);
  constexpr double angle = 0.8;
  for (std::size_t i = 0; i < 3; ++i) {
    Vector3<double> axis{};
    axis[i] = angle;
    const Placement turned{{}, exponential(axis)};
    const auto q = on_first(of, [&](const Point& x) {
      return turned.displacement(Vector3<double>(x) - Vector3<double>{1.0, 0.5, 0.5});
    });
    const double moment = i == 0 ? 1.0 / 6.0 : 1.0 / 12.0;
    EXPECT_NEAR(energy(of, q.get()), 0.5 * stiffness * std::pow(std::sin(angle), 2) * moment, 1e-12);
  }
}

TEST(SurfaceMeans, NoticeLines) {
  SurfaceMean mean;
  mean.area = 1.0;
  EXPECT_TRUE(mean.is_line());  // a point
  mean.second_moment = outer(Vector3<double>{1.0, 2.0, 3.0}, Vector3<double>{1.0, 2.0, 3.0});
  EXPECT_TRUE(mean.is_line());
  mean.second_moment = mean.second_moment + outer(Vector3<double>{0.1, 0.0, 0.0}, Vector3<double>{0.1, 0.0, 0.0});
  EXPECT_FALSE(mean.is_line());
}

}  // namespace
}  // namespace pliant::test_distributing_coupling
