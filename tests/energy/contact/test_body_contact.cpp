// Contact of two bodies: derivatives, balance of forces, the same numbers on every number of ranks, and step bounds.
#include "collision/candidates.hpp"
#include "energy/body_contact.hpp"
#include "energy/near_springs.hpp"
#include "petsc/collective.hpp"

#include <optional>

#include <fmt/format.h>

namespace pliant::test_body_contact {
namespace {

using test::Point;
using test::Scratch;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr double gap = 0.3, width = 0.1, stiffness = 7e4, between = 1.0 + 0.5 * gap;

/// The second body comes nearer, by `closer`, and is turned and shifted; both are strained from node to node.
test::Field approach(double closer) {
  return [closer](const Point& x) {
    Point u;
    for (int i = 0; i < 3; ++i) u[static_cast<std::size_t>(i)] = 0.01 * test::rough(x, i, 7);
    if (x[0] > between) {
      u[0] -= closer + 0.06 * (x[1] - 0.5) - 0.03 * x[2];
      u[1] += 0.13;
      u[2] -= 0.09;
    }
    return u;
  };
}

struct TwoBodies {
  TwoBodies(MPI_Comm of, const std::string& file, int order, double threshold = 0.0)
      : TwoBodies(of, file, order, test::barrier(stiffness, width - threshold, threshold)) {}
  TwoBodies(MPI_Comm of, const std::string& file, int order, const NormalLaw& law)
      : solid(of, file, order, 2),
        contact(make_body_contact(test::touching(solid, between, law))),
        prescribed(solid.nothing_prescribed()) {
    potential.emplace(solid.layout(), solid.pattern(), std::vector<const EnergyTerm*>{contact.get()}, prescribed);
    stage.emplace(solid, 0.0, 0.1);
    potential->begin_stage(stage->point);
  }
  Handle<Vec> product(Vec q, Vec d, Mat K, Projection projection = Projection::none) {
    potential->hessian(q, K, projection);
    Handle<Vec> y = potential->make_vector();
    check(MatMult(K, d, y.get()));
    return y;
  }

  Solid solid;
  std::unique_ptr<EnergyTerm> contact;
  std::vector<char> prescribed;
  std::optional<IncrementalPotential> potential;
  std::optional<TestStage> stage;
};

class BodyContactOf : public ::testing::TestWithParam<int> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
};

INSTANTIATE_TEST_SUITE_P(Order, BodyContactOf, ::testing::Values(1, 2));

TEST(BodySurfaces, HaveTheirVerticesAtTheNodesIfAsked) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
  const Solid solid(MPI_COMM_SELF, file, 2, 2);
  const auto surfaces = test::surfaces_of(solid, between, FacetVertices::nodes);
  const CollisionSurface& surface = surfaces->surface();
  std::vector<Vector3<double>> u;
  for (const auto& vertex : surface.vertices()) {
    const Point X = solid.layout().position(static_cast<PetscInt>(vertex.key));
    u.push_back({test::rough(X, 0, 3), test::rough(X, 1, 3), test::rough(X, 2, 3)});
  }
  const auto at_nodes = u;
  surfaces->place(u);
  EXPECT_EQ(u, at_nodes);
  EXPECT_EQ(surfaces->patches().nodes_per_patch, 3);
  EXPECT_EQ(surface.triangles().size(),
            test::surfaces_of(solid, between, FacetVertices::mean)->surface().triangles().size());
}

// The forces of a pressure on the triangles are then those of the facets' shape functions.
TEST(BodySurfaces, HaveTheMeanOfTheirFacets) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap); });
  for (const int order : {1, 2}) {
    const Solid solid(MPI_COMM_SELF, file, order, 2);
    const FacetList facets = surface_facets(solid.mesh(), solid.layout(), [](const auto&) { return true; });
    const auto surfaces = test::surfaces_of(solid, between);
    const CollisionSurface& surface = surfaces->surface();
    // A displacement at random of each node, all of which have a vertex.
    const auto displacement = [&](PetscInt node) {
      const Point X = solid.layout().position(node);
      return Vector3<double>{test::rough(X, 0, 3), test::rough(X, 1, 3), test::rough(X, 2, 3)};
    };
    std::vector<Vector3<double>> u;
    for (const auto& vertex : surface.vertices()) u.push_back(displacement(static_cast<PetscInt>(vertex.key)));
    surfaces->place(u);
    Vector3<double> of_triangles{}, of_facets{};
    for (const auto& triangle : surface.triangles()) {
      const auto [a, b, c] = triangle.vertices;
      of_triangles = of_triangles + (triangle.area / 3.0) * (u[a] + u[b] + u[c]);
    }
    const auto n = static_cast<std::size_t>(facets.nodes_per_facet);
    for (std::size_t first = 0; first < facets.nodes.size(); first += n) {
      const auto X = [&](std::size_t k) { return solid.layout().position(facets.nodes[first + k]); };
      const double area = 0.5 * norm(cross(X(1) - X(0), X(2) - X(0)));
      // Quadratic shape functions: the integral is a third of each mid-edge node's.
      for (std::size_t k = n - 3; k < n; ++k)
        of_facets = of_facets + (area / 3.0) * displacement(facets.nodes[first + k]);
    }
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(of_triangles[k], of_facets[k], 1e-13);
    EXPECT_GT(norm(of_facets), 1e-3);
  }
}

TEST_P(BodyContactOf, DerivativesAreThoseOfTheEnergy) {
  for (const double threshold : {0.0, 0.02}) {
    TwoBodies bodies(comm, file_, GetParam(), threshold);
    const Handle<Mat> K = bodies.potential->make_hessian();
    const Handle<Vec> d = bodies.solid.vector(test::rough_field(1.0, 3));
    const Handle<Vec> r = bodies.potential->make_vector(), before = bodies.potential->make_vector(),
                      after = bodies.potential->make_vector();
    for (const double closer : {0.2, 0.22, 0.18}) {
      const Handle<Vec> q = bodies.solid.vector(approach(closer));
      constexpr double h = 1e-7;
      const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
      bodies.potential->gradient(q.get(), r.get());
      const double slope = test::dot(r.get(), d.get());
      const double difference =
          (bodies.potential->value(ahead.get()) - bodies.potential->value(behind.get())) / (2.0 * h);
      EXPECT_NEAR(slope, difference, 1e-6 * test::norm(r.get())) << closer;
      EXPECT_GT(test::norm(r.get()), 0.0);

      const Handle<Vec> y = bodies.product(q.get(), d.get(), K.get());
      bodies.potential->gradient(ahead.get(), after.get());
      bodies.potential->gradient(behind.get(), before.get());
      check(VecAXPY(after.get(), -1.0, before.get()));
      check(VecScale(after.get(), 1.0 / (2.0 * h)));
      EXPECT_LT(test::distance(y.get(), after.get()), 2e-6 * test::norm(y.get())) << closer;

      // The projection changes the matrix, and leaves no negative curvature.
      const Handle<Vec> z = bodies.product(q.get(), d.get(), K.get(), Projection::positive_semidefinite);
      EXPECT_GT(test::distance(y.get(), z.get()), 1e-8 * test::norm(y.get()));
      // Contact is a wall, projected with the walls.
      const Handle<Vec> of_walls = bodies.product(q.get(), d.get(), K.get(), Projection::walls);
      EXPECT_EQ(test::distance(of_walls.get(), z.get()), 0.0);
      for (int seed = 10; seed < 30; ++seed) {
        const Handle<Vec> e = bodies.solid.vector(test::rough_field(1.0, seed)), Ke = bodies.potential->make_vector();
        check(MatMult(K.get(), e.get(), Ke.get()));
        EXPECT_GE(test::dot(e.get(), Ke.get()), 0.0);
      }
    }
  }
}

TEST_P(BodyContactOf, ForcesAndTheirMomentsBalance) {
  TwoBodies bodies(comm, file_, GetParam());
  const Handle<Vec> r = bodies.potential->make_vector();
  for (const double closer : {0.2, 0.22}) {
    const Handle<Vec> q = bodies.solid.vector(approach(closer));
    bodies.potential->gradient(q.get(), r.get());
    const auto total = test::resultant(bodies.solid, r.get(), q.get());
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(total.force[static_cast<std::size_t>(i)], 0.0, 1e-13 * test::norm(r.get()));
      EXPECT_NEAR(total.moment[static_cast<std::size_t>(i)], 0.0, 1e-12 * test::norm(r.get()));
    }
  }
}

// A rank alone has all surfaces; with more of them the interface lies across the cut.
TEST_P(BodyContactOf, NumbersAreThoseOfOneRank) {
  TwoBodies many(comm, file_, GetParam()), alone(MPI_COMM_SELF, file_, GetParam());
  const Handle<Mat> K = many.potential->make_hessian(), K_alone = alone.potential->make_hessian();
  const auto numbers_of = [](TwoBodies& bodies, Mat hessian, double closer) {
    const Handle<Vec> q = bodies.solid.vector(approach(closer)), d = bodies.solid.vector(test::rough_field(1.0, 5)),
                      e = bodies.solid.vector(test::rough_field(1.0, 6)), r = bodies.potential->make_vector();
    std::vector<double> numbers{bodies.potential->value(q.get())};
    bodies.potential->gradient(q.get(), r.get());
    numbers.push_back(test::dot(r.get(), d.get()));
    numbers.push_back(test::norm(r.get()));
    for (const Projection projection : {Projection::none, Projection::positive_semidefinite}) {
      const Handle<Vec> y = bodies.product(q.get(), d.get(), hessian, projection);
      numbers.push_back(test::dot(y.get(), e.get()));
      numbers.push_back(test::norm(y.get()));
    }
    numbers.push_back(bodies.potential->accounts().energies({}, q.get(), nullptr)[0]);
    const Handle<Vec> way = bodies.solid.vector([](const Point& x) {
      return Point{x[0] > between ? -0.5 : 0.0, 0, 0};
    });
    numbers.push_back(bodies.potential->max_step(q.get(), way.get()));
    return numbers;
  };
  for (const double closer : {0.2, -1.0, 0.18, 0.22}) {
    const auto here = numbers_of(many, K.get(), closer), there = numbers_of(alone, K_alone.get(), closer);
    EXPECT_EQ(there[0] > 0.0, closer > 0.0) << closer;
    for (std::size_t i = 0; i < here.size(); ++i) {
      if (std::isfinite(there[i])) {
        EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-11) << closer << " " << i;
      } else {
        EXPECT_EQ(here[i], there[i]);
      }
    }
  }
}

// A rank is asked for the triangles that it owns: they are among those that it lists, each on one rank, even where all
// nodes of a facet belong to another rank than its cell.
TEST_P(BodyContactOf, EveryTriangleIsOwnedOnce) {
  for (const int cubes : {3, 7}) {
    const std::string file = scratch_.file(fmt::format("more{}.msh", cubes), [&](const std::string& f) {
      test::write_body(f, {1, test::Shape::jittered, cubes});
    });
    const Solid solid(comm, file, GetParam(), 0);
    const auto surfaces = test::surfaces_of(solid, between);
    const Patches& patches = surfaces->patches();
    std::vector<double> owners(surfaces->surface().triangles().size(), 0.0);
    for (std::size_t n = 0; n < patches.size(); ++n) owners[patches.keys[n]] += patches.is_owned[n] != 0 ? 1.0 : 0.0;
    sum_in_place(comm, owners);
    EXPECT_EQ(std::ranges::count(owners, 1.0), static_cast<std::ptrdiff_t>(owners.size())) << cubes;
  }
}

/// The surface of both bodies at q, on a rank alone.
std::vector<BoxPair> intersections(const Solid& solid, Vec q) {
  const auto surfaces = test::surfaces_of(solid, between);
  const CollisionSurface& surface = surfaces->surface();
  const ArrayView entries(q);
  std::vector<Vector3<double>> x(surface.rest_positions().begin(), surface.rest_positions().end());
  for (std::size_t v = 0; v < x.size(); ++v) {
    for (std::size_t i = 0; i < 3; ++i) x[v][i] += entries[3 * surface.vertices()[v].key + static_cast<PetscInt>(i)];
  }
  return find_intersections(surface, x);
}

// The longest step that is allowed ends before bodies meet, however far beyond the direction leads.
TEST_P(BodyContactOf, StepsEndBeforeBodiesMeet) {
  TwoBodies bodies(MPI_COMM_SELF, file_, GetParam());
  const Handle<Vec> q = bodies.solid.vector(approach(0.1));
  for (const double length : {0.3, 0.6, 2.0}) {
    for (int seed = 0; seed < 5; ++seed) {
      const Handle<Vec> d = bodies.solid.vector([&](const Point& x) {
        Point way;
        for (int i = 0; i < 3; ++i) way[static_cast<std::size_t>(i)] = 0.2 * test::rough(x, i, seed);
        way[0] += x[0] > between ? -length : 0.0;
        return way;
      });
      const double alpha = bodies.potential->max_step(q.get(), d.get());
      ASSERT_LT(alpha, 1.0);
      ASSERT_GT(alpha, 0.0);
      const Handle<Vec> end = test::moved(q.get(), alpha, d.get()), beyond = test::moved(q.get(), 1.0, d.get());
      EXPECT_TRUE(intersections(bodies.solid, end.get()).empty());
      EXPECT_TRUE(std::isfinite(bodies.potential->value(end.get())));
      if (length < 1.0) {
        EXPECT_FALSE(intersections(bodies.solid, beyond.get()).empty());
      }
    }
  }
}

/// They are in each other, by up to 0.1, or have a layer of that thickness around them.
struct PenaltyCase {
  double closer;
  NormalLaw law;
};
const std::vector<PenaltyCase> penalties{{0.32, {NormalKind::penalty, stiffness, 0.01, 0.0}},
                                         {0.35, {NormalKind::penalty, stiffness, 0.01, 0.0}},
                                         {0.27, {NormalKind::penalty, stiffness, 0.02, 0.1}},
                                         {0.31, {NormalKind::penalty, stiffness, 0.02, 0.1}}};

TEST_P(BodyContactOf, DerivativesOfAPenaltyAreThoseOfTheEnergy) {
  for (const auto& [closer, law] : penalties) {
    TwoBodies bodies(comm, file_, GetParam(), law);
    const Handle<Mat> K = bodies.potential->make_hessian();
    const Handle<Vec> d = bodies.solid.vector(test::rough_field(1.0, 3)), q = bodies.solid.vector(approach(closer)),
                      r = bodies.potential->make_vector(), before = bodies.potential->make_vector(),
                      after = bodies.potential->make_vector();
    constexpr double h = 1e-8;
    const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
    bodies.potential->gradient(q.get(), r.get());
    EXPECT_GT(test::norm(r.get()), 0.0);
    const double difference =
        (bodies.potential->value(ahead.get()) - bodies.potential->value(behind.get())) / (2.0 * h);
    EXPECT_NEAR(test::dot(r.get(), d.get()), difference, 1e-5 * test::norm(r.get())) << closer;
    const Handle<Vec> y = bodies.product(q.get(), d.get(), K.get());
    bodies.potential->gradient(ahead.get(), after.get());
    bodies.potential->gradient(behind.get(), before.get());
    check(VecAXPY(after.get(), -1.0, before.get()));
    check(VecScale(after.get(), 1.0 / (2.0 * h)));
    EXPECT_LT(test::distance(y.get(), after.get()), 1e-5 * test::norm(y.get())) << closer;
    (void)bodies.product(q.get(), d.get(), K.get(), Projection::positive_semidefinite);
    for (int seed = 10; seed < 30; ++seed) {
      const Handle<Vec> e = bodies.solid.vector(test::rough_field(1.0, seed)), Ke = bodies.potential->make_vector();
      check(MatMult(K.get(), e.get(), Ke.get()));
      EXPECT_GE(test::dot(e.get(), Ke.get()), -1e-12 * test::norm(Ke.get()) * test::norm(e.get()));
    }
    // Forces balance, and push the bodies apart, whoever is in whom.
    const auto total = test::resultant(bodies.solid, r.get(), q.get());
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(total.force[i], 0.0, 1e-13 * test::norm(r.get()));
      EXPECT_NEAR(total.moment[i], 0.0, 1e-12 * test::norm(r.get()));
    }
    const Handle<Vec> apart = bodies.solid.vector([](const Point& x) {
      return Point{x[0] > between ? 1.0 : 0.0, 0, 0};
    });
    EXPECT_LT(test::dot(r.get(), apart.get()), -0.9 * std::abs(test::dot(r.get(), r.get())) / test::norm(r.get()));
    EXPECT_TRUE(std::isinf(bodies.potential->max_step(q.get(), apart.get())));
  }
}

TEST_P(BodyContactOf, NumbersOfAPenaltyAreThoseOfOneRank) {
  for (const auto& [closer, law] : penalties) {
    TwoBodies many(comm, file_, GetParam(), law), alone(MPI_COMM_SELF, file_, GetParam(), law);
    const Handle<Mat> K = many.potential->make_hessian(), K_alone = alone.potential->make_hessian();
    const auto numbers_of = [&, at = closer](TwoBodies& bodies, Mat hessian) {
      const Handle<Vec> q = bodies.solid.vector(approach(at)), d = bodies.solid.vector(test::rough_field(1.0, 5)),
                        e = bodies.solid.vector(test::rough_field(1.0, 6)), r = bodies.potential->make_vector();
      std::vector<double> numbers{bodies.potential->value(q.get())};
      bodies.potential->gradient(q.get(), r.get());
      numbers.push_back(test::dot(r.get(), d.get()));
      numbers.push_back(test::norm(r.get()));
      const Handle<Vec> y = bodies.product(q.get(), d.get(), hessian);
      numbers.push_back(test::dot(y.get(), e.get()));
      numbers.push_back(bodies.potential->accounts().energies({}, q.get(), nullptr)[0]);
      return numbers;
    };
    const auto here = numbers_of(many, K.get()), there = numbers_of(alone, K_alone.get());
    for (std::size_t i = 0; i < here.size(); ++i)
      EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-11) << i;
  }
}

}  // namespace
}  // namespace pliant::test_body_contact
