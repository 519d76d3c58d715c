#include "base/limits.hpp"
#include "collision/contact_pairs.hpp"
#include "collision/shared_pairs.hpp"
#include "laws.hpp"
#include "surfaces.hpp"

#include <eigen3/Eigen/Dense>
#include <set>

#include <gtest/gtest.h>

namespace pliant::test_contact_pairs {
namespace {

using namespace testing_collision;

constexpr double reach = 0.1;  // [m]

/// The laws of laws.hpp with their distances in units of the reach.
Response barrier_law(double d) {
  const Response r = barrier(d / reach);
  return {r.energy, r.pressure / reach, r.stiffness / (reach * reach)};
}
Response penalty_law(double d) {
  const Response r = penalty(d / reach);
  return {r.energy, r.pressure / reach, r.stiffness / (reach * reach)};
}

/// The whole way from positions to the potential.
struct Contact {
  CollisionSurface surface;
  FeatureMultiplicities multiplicities;
  std::vector<SurfacePoint> points;
  double edge_share = 0.0;
  Response (*law)(double) = barrier_law;

  Contact(const SurfaceInput& input, const ContactRule& rule, double share = 0.0)

      : surface(input.surface()),
        multiplicities(surface, {}),
        points(surface_points(surface, rule)),
        edge_share(share) {}

  std::vector<Vector3<double>> rest() const {
    return {surface.rest_positions().begin(), surface.rest_positions().end()};
  }
  ContactPairs pairs(std::span<const Vector3<double>> x) const {
    return {point_pairs(surface, multiplicities, points, point_candidates(surface, points, x, reach), x, reach),
            edge_share > 0.0 ? edge_pairs(surface, find_candidates(surface, x, reach).edge_edge, x, reach, edge_share)
                             : std::vector<EdgePair>{}};
  }
  template <class AddBlock>
  double evaluate(std::span<const Vector3<double>> x, ContactOrder order, std::vector<Vector3<double>>& forces,
                  const AddBlock& add_block) const {
    forces.assign(x.size(), {});
    const auto add = [&](std::int32_t v, const Vector3<double>& f) { forces[v] = forces[v] + f; };
    const ContactPairs near = pairs(x);
    const auto law_of = [&](int, int, double d) { return law(d); };
    return add_point_pairs(surface, points, near.points, x, law_of, order, add, add_block) +
           add_edge_pairs(surface, near.edges, x, law_of, order, add, add_block);
  }
  double gradient(std::span<const Vector3<double>> x, std::vector<Vector3<double>>& forces) const {
    return evaluate(x, ContactOrder::gradient, forces, [](auto...) {});
  }
};

ContactRule corners() {
  return {};
}

/// A patch and the corner of a tetrahedron above it, whose last four vertices move.
Contact probe_over(const SurfaceInput& floor, double share = 0.0) {
  SurfaceInput probe;
  probe.vertices = {{5000, {0, 0, 0}}, {5001, {1, 0, 2}}, {5002, {0, 1, 2}}, {5003, {-1, -1, 2}}};
  probe.triangles = {{{5000, 5001, 5002}, 1, 0}, {{5000, 5002, 5003}, 1, 0}, {{5000, 5003, 5001}, 1, 0}};
  return {joined(floor, probe), corners(), share};
}
void place_probe(std::vector<Vector3<double>>& x, const Vector3<double>& tip) {
  const std::size_t first = x.size() - 4;
  const std::array<Vector3<double>, 4> shape{{{0, 0, 0}, {1, 0, 2}, {0, 1, 2}, {-1, -1, 2}}};
  for (std::size_t n = 0; n < 4; ++n) x[first + n] = tip + shape[n];
}

/// However the triangles at a vertex are connected: a point close to it, but to nothing else, sees it once.
TEST(ContactPairs, EveryVertexCountsOnce) {
  SurfaceInput fins = patch(3, 0.0, 0, 0, 2);
  fins.vertices.push_back({100, {0.5, 0.5, 1}});
  fins.vertices.push_back({101, {0.3, 0.9, 1}});
  fins.triangles.push_back({{0, 1, 100}, 0, 0});     // a third triangle at an edge of the boundary
  fins.triangles.push_back({{5, 6, 100}, 0, 0});     // and at an inner edge
  fins.triangles.push_back({{10, 101, 100}, 0, 0});  // one connected by two vertices
  const Contact contact = probe_over(fins);
  auto x = contact.rest();
  const auto tip = static_cast<std::int32_t>(x.size() - 4);
  for (std::int32_t v = 0; v < tip; ++v) {
    place_probe(x, x[v] + Vector3<double>{0.3e-6, 0.2e-6, 0.1e-6});
    std::vector<BoxPair> candidates;
    for (std::size_t t = 0; t < contact.surface.triangles().size(); ++t) {
      if (!contact.surface.is_incident(contact.surface.triangles()[t], tip))
        candidates.push_back({tip, static_cast<std::int32_t>(t)});
    }
    int count = 0;
    for (const PointPair& pair :
         point_pairs(contact.surface, contact.multiplicities, contact.points, candidates, x, 1e-6)) {
      count += pair.multiplicity;
    }
    EXPECT_EQ(count, 1) << v;
  }
}

TEST(ContactPairs, PointSlidesOverAFlatSurfaceAsOverAPlane) {
  const Contact contact = probe_over(patch(6, 0.0, 0, 0, 1));
  auto x = contact.rest();
  const std::size_t tip = x.size() - 4;
  const double height = 0.04, area = contact.points[tip].area;
  const Response expected = contact.law(height);
  RandomPoints random(2);
  int seen = 0;
  std::vector<Vector3<double>> forces;
  for (int trial = 0; trial < 8000; ++trial) {
    Vector3<double> place{random.number(0.15, 0.85), random.number(0.15, 0.85), height};
    const auto& triangle = contact.surface.triangles()[trial % 72].vertices;
    if (trial % 3 == 1) {  // over a vertex
      place = x[triangle[0]];
    } else if (trial % 3 == 2) {  // over an edge
      const double s = random.number(0.0, 1.0);
      place = (1 - s) * x[triangle[0]] + s * x[triangle[1]];
    }
    place[2] = height;
    if (std::min({place[0], place[1], 1 - place[0], 1 - place[1]}) < 0.12) continue;
    place_probe(x, place);
    const double W = contact.gradient(x, forces);
    const auto near = contact.pairs(x).points;
    const auto is_of_tip = [&](const PointPair& pair) { return pair.point == static_cast<std::int32_t>(tip); };
    if (trial % 3 == 0) {  // nothing is left of what cancels; on an edge rounding decides who has the place
      EXPECT_EQ(std::ranges::count_if(near, is_of_tip), 1);
    }
    if (!std::ranges::all_of(near, is_of_tip)) continue;  // a vertex of the floor is near the tip, and pushes too
    EXPECT_NEAR(forces[tip][2], -0.5 * area * expected.pressure, 1e-12 * area * expected.pressure);
    EXPECT_NEAR(norm(forces[tip]), 0.5 * area * expected.pressure, 1e-12 * area * expected.pressure);
    EXPECT_NEAR(W, 0.5 * area * expected.energy, 1e-13 * area * expected.energy);
    ++seen;
  }
  EXPECT_GT(seen, 300);
}

// The edges of the tip cross those of the floor, which are none of the body.
TEST(ContactPairs, EdgesInsideAPlaneOfARigidBodyPushNothing) {
  constexpr double share = 0.05;
  const auto edges_near = [](const Contact& contact) {
    auto x = contact.rest();
    RandomPoints random(5);
    std::size_t number = 0;
    for (int trial = 0; trial < 200; ++trial) {
      place_probe(x, {random.number(0.15, 0.85), random.number(0.15, 0.85), 0.04});
      number += contact.pairs(x).edges.size();
    }
    return number;
  };
  SurfaceInput floor = patch(6, 0.0, 0, 0, 1);
  EXPECT_GT(edges_near(probe_over(floor, share)), 50U);
  for (auto& triangle : floor.triangles) triangle.rigid_part = 1;
  EXPECT_EQ(edges_near(probe_over(floor, share)), 0U);
}

/// Forces over a bumpy surface change no faster than the way: a tenth of the step, a tenth of the largest change.
TEST(ContactPairs, PotentialIsContinuouslyDifferentiableAcrossEdges) {
  SurfaceInput floor = patch(6, 0.0, 0, 0, 3);
  RandomPoints random(4);
  for (auto& vertex : floor.vertices) vertex.X[2] = random.number(-0.03, 0.03);
  const Contact contact = probe_over(floor, 0.1);
  auto x = contact.rest();
  std::vector<Vector3<double>> forces, previous;
  const auto largest_change = [&](int steps) {
    double most = 0.0, W_before = 0.0, most_W = 0.0;
    previous.clear();
    for (int n = 0; n <= steps; ++n) {
      const double s = static_cast<double>(n) / steps;
      place_probe(x, {0.2 + 0.6 * s, 0.3 + 0.37 * s, 0.075});
      const double W = contact.gradient(x, forces);
      for (std::size_t v = 0; v < previous.size(); ++v) most = std::max(most, norm(forces[v] - previous[v]));
      if (n > 0) most_W = std::max(most_W, std::abs(W - W_before));
      previous = forces;
      W_before = W;
    }
    EXPECT_GT(most_W, 0.0);
    return std::array{most, most_W};
  };
  const auto coarse = largest_change(2000), fine = largest_change(20000);
  EXPECT_LT(fine[0], 0.15 * coarse[0]);
  EXPECT_LT(fine[1], 0.15 * coarse[1]);
}

/// Two squares of different triangulations at the distance h.
Contact two_patches(int n, int m, double height, const ContactRule& rule, double share = 0.0) {
  return {joined(patch(n, 0.0, 0, 0, 5), patch(m, height, 100000, 1, 6)), rule, share};
}

TEST(ContactPairs, EnergyBetweenFlatPatchesIsThatOfTheirGap) {
  constexpr double height = 0.05;
  for (const ContactRule& rule : {corners(), quadratic_contact_rule()}) {
    const Contact contact = two_patches(5, 4, height, rule);
    std::vector<Vector3<double>> forces;
    EXPECT_NEAR(contact.gradient(contact.rest(), forces), contact.law(height).energy, 1e-13);
    double up = 0.0;
    for (std::size_t v = 0; v < forces.size(); ++v) up += contact.surface.vertices()[v].body == 1 ? forces[v][2] : 0.0;
    EXPECT_NEAR(-up, contact.law(height).pressure, 1e-12);
  }
}

/// The work of the forces along smooth displacements goes to that of a uniform pressure.
TEST(ContactPairs, PressureBetweenFlatPatchesBecomesUniform) {
  constexpr double height = 0.05;
  const auto work_error = [&](int n, int m, const ContactRule& rule) {
    const Contact contact = two_patches(n, m, height, rule);
    std::vector<Vector3<double>> forces;
    contact.gradient(contact.rest(), forces);
    double work = 0.0;  // along u_z = sin(pi x) y, on one side; over the square 1/pi
    for (std::size_t v = 0; v < forces.size(); ++v) {
      const auto& X = contact.surface.rest_positions()[v];
      if (contact.surface.vertices()[v].body == 1) work -= forces[v][2] * std::sin(3.14159265358979 * X[0]) * X[1];
    }
    return std::abs(work / contact.law(height).pressure * 3.14159265358979 - 1.0);
  };
  const double coarse = work_error(5, 4, corners()), fine = work_error(20, 16, corners());
  const double coarse_quadratic = work_error(5, 4, quadratic_contact_rule());
  const double fine_quadratic = work_error(20, 16, quadratic_contact_rule());
  RecordProperty("coarse", std::to_string(coarse));
  EXPECT_LT(fine, 0.15 * coarse);
  EXPECT_LT(fine_quadratic, 0.15 * coarse_quadratic);
  EXPECT_LT(fine, 5e-3);
  EXPECT_LT(fine_quadratic, 5e-3);
}

/// Two bumpy patches, in general position.
struct Bumpy {
  Contact contact;
  std::vector<Vector3<double>> x;

  explicit Bumpy(const ContactRule& rule) : contact(two_patches(3, 4, 0.05, rule, 0.2)), x(contact.rest()) {
    RandomPoints random(7);
    for (auto& p : x) p = p + random.point(0.01);
  }
};

/// The gradient against differences of the energy, and the Hessian against those of the gradient.
void expect_derivatives(const Contact& contact, std::vector<Vector3<double>> x) {
  const auto size = static_cast<Eigen::Index>(3 * x.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, size);
  std::vector<Vector3<double>> forces, right, left;
  contact.evaluate(x, ContactOrder::hessian, forces, [&](std::int32_t a, std::int32_t b, const Tensor3<double>& block) {
    for (int p = 0; p < 3; ++p) {
      for (int q = 0; q < 3; ++q) K(3 * a + p, 3 * b + q) += block(p, q);
    }
  });
  EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
  constexpr double step = 1e-7;
  double largest_force = 0.0;
  for (const auto& f : forces) largest_force = std::max(largest_force, norm(f));
  ASSERT_GT(largest_force, 0.01);
  int off = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    for (int q = 0; q < 3; ++q) {
      const double before = x[v][q];
      x[v][q] = before + step;
      const double W_right = contact.gradient(x, right);
      x[v][q] = before - step;
      const double W_left = contact.gradient(x, left);
      x[v][q] = before;
      EXPECT_NEAR((W_right - W_left) / (2 * step), forces[v][q], 1e-6 * largest_force);
      for (std::size_t w = 0; w < x.size(); ++w) {
        for (int p = 0; p < 3; ++p) {
          const double second = (right[w][p] - left[w][p]) / (2 * step);
          off += std::abs(second - K(3 * w + p, 3 * v + q)) > 1e-5 * K.cwiseAbs().maxCoeff() ? 1 : 0;
        }
      }
    }
  }
  EXPECT_EQ(off, 0);
}

TEST(ContactPairs, DerivativesMatchDifferences) {
  for (const ContactRule& rule : {corners(), quadratic_contact_rule()}) {
    const Bumpy bumpy(rule);
    expect_derivatives(bumpy.contact, bumpy.x);
  }
}

/// A rod along these points, with keys from `first_key` on.
SurfaceInput rod(const std::vector<Vector3<double>>& points, VertexKey first_key, std::int32_t body,
                 double thickness = 0.02) {
  SurfaceInput input;
  for (const auto& X : points) input.vertices.push_back({first_key + std::ssize(input.vertices), X});
  for (VertexKey key = first_key; key + 1 < first_key + std::ssize(points); ++key) {
    input.triangles.push_back({{key + 1, key, key}, body, 0, thickness});
  }
  return input;
}

TEST(ContactPairs, DerivativesOfRodsMatchDifferences) {
  const auto across = rod({{0.2, -0.3, 0.04}, {0.45, 0.2, 0.05}, {0.5, 0.7, 0.045}, {0.6, 1.2, 0.06}}, 1000, 1);
  const auto along = rod({{-0.2, 0.4, 0.09}, {0.3, 0.45, 0.1}, {0.7, 0.5, 0.095}}, 2000, 2);
  const Contact contact(joined(joined(patch(3, 0.0, 0, 0, 5), across), along), quadratic_contact_rule(), 0.2);
  const auto pairs = contact.pairs(contact.rest());
  std::set<std::array<std::int32_t, 2>> bodies;  // of pairs of edges
  for (const EdgePair& pair : pairs.edges) {
    bodies.insert({contact.surface.edges()[pair.a].body, contact.surface.edges()[pair.b].body});
  }
  EXPECT_EQ(bodies.size(), 3U);  // each rod with the patch, and the rods
  expect_derivatives(contact, contact.rest());
}

/// Chains, forks, and what is joined to a surface: a point close to a place of them sees it once.
TEST(ContactPairs, EveryPlaceOfARodCountsOnce) {
  SurfaceInput input = patch(2, 0.0, 0, 0, 2);
  const VertexKey inner = 4, rim = 1;
  for (const auto& [key, X] : std::vector<std::pair<VertexKey, Vector3<double>>>{
           {100, {0.5, 0.5, 0.5}}, {101, {0.5, 0.5, 1}}, {102, {1, 0.5, 0.6}}, {103, {0.5, 1, 0.6}}}) {
    input.vertices.push_back({key, X});
  }
  for (const auto& [a, b] :
       std::vector<std::pair<VertexKey, VertexKey>>{{inner, 100}, {100, 101}, {100, 102}, {103, 100}, {rim, 102}}) {
    input.triangles.push_back({{a, b, b}, 0, 0, 0.01});
  }
  const Contact contact = probe_over(input);
  auto x = contact.rest();
  const auto tip = static_cast<std::int32_t>(x.size() - 4);
  std::vector<Vector3<double>> places(x.begin(), x.begin() + tip);
  for (const auto& edge : contact.surface.edges()) {
    if (edge.is_loose) places.push_back(0.3 * x[edge.vertices[0]] + 0.7 * x[edge.vertices[1]]);
  }
  EXPECT_EQ(places.size(), 13U + 5U);
  for (const auto& place : places) {
    place_probe(x, place + Vector3<double>{0.3e-6, 0.2e-6, 0.1e-6});
    const auto candidates = point_candidates(contact.surface, contact.points, x, 1e-6);
    int count = 0;
    for (const PointPair& pair :
         point_pairs(contact.surface, contact.multiplicities, contact.points, candidates, x, 1e-6)) {
      if (pair.point == tip) count += pair.multiplicity;
    }
    EXPECT_EQ(count, 1) << place[0] << " " << place[1] << " " << place[2];
  }
}

TEST(ContactPairs, ForcesAndMomentsBalance) {
  const Bumpy bumpy(quadratic_contact_rule());
  std::vector<Vector3<double>> forces;
  bumpy.contact.gradient(bumpy.x, forces);
  Vector3<double> force{}, moment{};
  double size = 0.0;
  for (std::size_t v = 0; v < forces.size(); ++v) {
    force = force + forces[v];
    moment = moment + cross(bumpy.x[v], forces[v]);
    size += norm(forces[v]);
  }
  EXPECT_GT(size, 1.0);
  EXPECT_LT(norm(force), 1e-13 * size);
  EXPECT_LT(norm(moment), 1e-13 * size);
}

TEST(ContactPairs, SemidefiniteHessianIsOne) {
  Bumpy bumpy(quadratic_contact_rule());
  bumpy.contact.law = penalty_law;
  const auto size = static_cast<Eigen::Index>(3 * bumpy.x.size());
  const auto least_eigenvalue = [&](ContactOrder order) {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(size, size);
    std::vector<Vector3<double>> forces;
    bumpy.contact.evaluate(bumpy.x, order, forces, [&](std::int32_t a, std::int32_t b, const Tensor3<double>& block) {
      for (int p = 0; p < 3; ++p) {
        for (int q = 0; q < 3; ++q) K(3 * a + p, 3 * b + q) += block(p, q);
      }
    });
    return K.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() / K.norm();
  };
  EXPECT_LT(least_eigenvalue(ContactOrder::hessian), -1e-4);
  EXPECT_GE(least_eigenvalue(ContactOrder::semidefinite_hessian), -1e-13);
}

/// A roof over the line x = 0.5 of the unit square, two by two triangles, and a tetrahedron that dips into it from
/// above.
Contact probe_below_ridge() {
  SurfaceInput roof;
  roof.vertices = {{0, {0, 0, 0}}, {1, {0.5, 0, 0.1}}, {2, {1, 0, 0}},
                   {3, {0, 1, 0}}, {4, {0.5, 1, 0.1}}, {5, {1, 1, 0}}};
  roof.triangles = {{{0, 1, 4}, 0, 0}, {{0, 4, 3}, 0, 0}, {{1, 2, 5}, 0, 0}, {{1, 5, 4}, 0, 0}};
  return probe_over(roof);
}

TEST(ContactPairs, SharesOfFacetsChangeWithoutAJumpBelowARidge) {
  const Contact contact = probe_below_ridge();
  auto x = contact.rest();
  const auto normal_at = [&](double at) {
    place_probe(x, {at, 0.4, 0.05});
    auto candidates = point_candidates(contact.surface, contact.points, x, 0.3);
    sort_pairs(candidates, contact.points.size());
    const auto nearest =
        nearest_pairs(contact.surface, contact.multiplicities, contact.points, candidates, x, reach, 0.3);
    Vector3<double> normal{};
    double total = 0.0;
    for (const auto& [pair, share] : shared_pairs(contact.surface, contact.points, nearest, candidates, x)) {
      const PairGeometry geometry = geometry_of(contact.surface, contact.points, pair, x);
      if (geometry.body != 1 || contact.points[pair.point].nodes[0] != static_cast<std::int32_t>(x.size()) - 4)
        continue;
      EXPECT_GT(share, 0.0);
      normal = normal + share * geometry.normal;
      total += share;
    }
    EXPECT_NEAR(total, 1.0, 1e-14);
    return normal;
  };
  const Vector3<double> left = normal_at(0.4), right = normal_at(0.6);
  EXPECT_NEAR(left[0], -0.2 / std::sqrt(1.04), 1e-12);  // far from the ridge that of the facet
  EXPECT_NEAR(right[0], 0.2 / std::sqrt(1.04), 1e-12);
  EXPECT_NEAR(normal_at(0.5 - 1e-9)[0], normal_at(0.5 + 1e-9)[0], 1e-6);
  double last = left[0], most = 0.0;
  constexpr int steps = 2000;
  for (int n = 1; n <= steps; ++n) {
    const double now = normal_at(0.4 + 0.2 * n / steps)[0];
    most = std::max(most, std::abs(now - last));
    last = now;
  }
  EXPECT_LT(most, 0.02 * (right[0] - left[0]));
}

TEST(ContactPairs, RulesHaveTheAreaOfTheSurface) {
  for (const ContactRule& rule : {corners(), quadratic_contact_rule()}) {
    const auto surface = cube().surface();
    double area = 0.0;
    for (const auto& point : surface_points(surface, rule)) area += point.area;
    EXPECT_NEAR(area, 6.0, 1e-14);
  }
}

}  // namespace
}  // namespace pliant::test_contact_pairs
