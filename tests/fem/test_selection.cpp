// Parts of the mesh: each facet counted once over the ranks, each node's facets complete on its owner.
#include "fem/body.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"
#include "fem/selection.hpp"

#include <map>

namespace pliant::test_selection {
namespace {

using test::Body;
using test::BodySpec;
using test::BoxOptions;
using test::Key;
using test::key_of;
using test::Point;
using test::Scratch;
using test::Shape;
using test::write_box_msh;

const MPI_Comm comm = MPI_COMM_WORLD;

/// Area of a facet, by a rule that is exact for flat ones.
template <int Order>
double area(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  const auto rule = simplex_rule<2>(9);
  double total = 0.0;
  for (int q = 0; q < rule.size(); ++q) {
    const auto dN = Triangle<Order>::gradients(rule.points[q]);
    Point t{}, s{};
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const Point x = layout.position(nodes[a]);
      for (int k = 0; k < 3; ++k) {
        t[k] += dN[a][0] * x[k];
        s[k] += dN[a][1] * x[k];
      }
    }
    total +=
        rule.weights[q] * std::hypot(t[1] * s[2] - t[2] * s[1], t[2] * s[0] - t[0] * s[2], t[0] * s[1] - t[1] * s[0]);
  }
  return total;
}

/// int X . n dA and int n dA over a facet.
template <int Order>
std::pair<double, Point> flux_of(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  const auto rule = simplex_rule<2>(6);
  double flux = 0.0;
  Point total{};
  for (int q = 0; q < rule.size(); ++q) {
    const auto N = Triangle<Order>::values(rule.points[q]);
    const auto dN = Triangle<Order>::gradients(rule.points[q]);
    Point x{}, t{}, s{};
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const Point X = layout.position(nodes[a]);
      for (int k = 0; k < 3; ++k) {
        x[k] += N[a] * X[k];
        t[k] += dN[a][0] * X[k];
        s[k] += dN[a][1] * X[k];
      }
    }
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      const double n = rule.weights[q] * (t[i] * s[j] - t[j] * s[i]);
      flux += x[k] * n;
      total[k] += n;
    }
  }
  return {flux, total};
}

class Selections : public test::OnBodies {
 protected:
  std::span<const PetscInt> nodes_of(const FacetList& facets, PetscInt f) const {
    return std::span(facets.nodes).subspan(f * facets.nodes_per_facet, facets.nodes_per_facet);
  }
  double area_of(std::span<const PetscInt> nodes) const {
    return GetParam().order == 1 ? area<1>(layout_, nodes) : area<2>(layout_, nodes);
  }
  double owned_area(const FacetList& facets) const {
    double mine = 0.0;
    for (PetscInt f = 0; f < facets.size(); ++f) {
      if (facets.is_owned[f]) mine += area_of(nodes_of(facets, f));
    }
    return sum(comm, mine);
  }
  /// One key per owned facet.
  std::vector<Key> owned_places(const FacetList& facets) const {
    std::vector<Key> places;
    for (PetscInt f = 0; f < facets.size(); ++f) {
      if (!facets.is_owned[f]) continue;
      Point m{};
      for (const PetscInt n : nodes_of(facets, f).first(3)) {
        for (int k = 0; k < 3; ++k) m[k] += layout_.position(n)[k] / 3.0;
      }
      places.push_back(key_of(m));
    }
    return places;
  }
  /// Each owned node has the facets (or edges, given by their nodes) around it that it has on one rank.
  void expect_complete(const std::vector<PetscInt>& nodes, const NodeLayout& whole,
                       const std::vector<PetscInt>& all) const {
    std::map<Key, int> expected, here;
    for (const PetscInt n : all) ++expected[key_of(whole.position(n))];
    for (const PetscInt n : nodes) {
      if (n < layout_.num_owned_nodes) ++here[key_of(layout_.position(n))];
    }
    for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
      const Key key = key_of(layout_.position(a));
      EXPECT_EQ(here[key], expected[key]);
    }
  }
};

// n = 7 on three ranks: a facet whose nodes all belong to other ranks than its own.
INSTANTIATE_TEST_SUITE_P(Bodies, Selections,
                         ::testing::Values(BodySpec{1, Shape::straight, 1}, BodySpec{1, Shape::straight, 7},
                                           BodySpec{2, Shape::straight, 1}, BodySpec{1, Shape::jittered, 4},
                                           BodySpec{2, Shape::jittered, 3}, BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Selections, NodesOfASurfaceGroupAreThoseOnIt) {
  const int along = GetParam().order * GetParam().n + 1;
  const auto clamp = nodes_of_group(body_.mesh, layout_, test::group_named(body_.mesh, "clamp"));
  EXPECT_EQ(sum(comm, static_cast<PetscInt64>(clamp.size())), along * along);
  EXPECT_TRUE(std::is_sorted(clamp.begin(), clamp.end()));
  for (const PetscInt n : clamp) {
    ASSERT_LT(n, layout_.num_owned_nodes);
    if (GetParam().shape != Shape::curved) {
      EXPECT_EQ(layout_.position(n)[0], 0.0);
    }
  }
  const auto all = nodes_of_group(body_.mesh, layout_, test::group_named(body_.mesh, "body"));
  EXPECT_EQ(static_cast<PetscInt>(all.size()), layout_.num_owned_nodes);
}

TEST_P(Selections, NodesInARegion) {
  const auto nodes = nodes_in_region(layout_, [](const Point& x) { return x[2] > 0.4; });
  std::vector<PetscInt> expected;
  for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
    if (layout_.position(a)[2] > 0.4) expected.push_back(a);
  }
  EXPECT_EQ(nodes, expected);
  EXPECT_GT(sum(comm, static_cast<PetscInt64>(nodes.size())), 0);
}

TEST_P(Selections, FacetsOfAGroupHaveItsArea) {
  const auto facets = facets_of_group(body_.mesh, layout_, test::group_named(body_.mesh, "tip"));
  EXPECT_EQ(facets.is_owned.size(), static_cast<std::size_t>(facets.size()));
  const int n = GetParam().n;
  const auto places = test::counted_everywhere(comm, owned_places(facets));
  EXPECT_EQ(static_cast<int>(places.size()), 2 * n * n);
  for (const auto& [place, count] : places) EXPECT_EQ(count, 1);
  const Body whole(MPI_COMM_SELF, file_, GetParam().order);
  const auto all = facets_of_group(whole.mesh, whole.layout, test::group_named(whole.mesh, "tip"));
  double expected = 0.0;
  for (PetscInt f = 0; f < all.size(); ++f) {
    const auto nodes = std::span(all.nodes).subspan(f * all.nodes_per_facet, all.nodes_per_facet);
    expected += GetParam().order == 1 ? area<1>(whole.layout, nodes) : area<2>(whole.layout, nodes);
  }
  if (GetParam().shape != Shape::curved) {
    EXPECT_NEAR(expected, 1.0, 1e-13);
  }
  EXPECT_NEAR(owned_area(facets), expected, 1e-12);
  expect_complete(facets.nodes, whole.layout, all.nodes);
}

TEST_P(Selections, EdgesOfACurveAreFoundOnceAndCompleteAtTheirNodes) {
  const auto edges = edges_of_group(body_.mesh, layout_, test::group_named(body_.mesh, "edge"));
  const int per_edge = edges.nodes_per_edge;
  ASSERT_EQ(per_edge, GetParam().order + 1);
  ASSERT_EQ(edges.is_owned.size(), static_cast<std::size_t>(edges.size()));
  PetscInt64 owned = 0;
  for (PetscInt e = 0; e < edges.size(); ++e) {
    owned += edges.is_owned[e];
    if (per_edge == 2 || GetParam().shape == Shape::curved) continue;
    const auto x = [&](int a) { return layout_.position(edges.nodes[e * per_edge + a])[0]; };
    EXPECT_NEAR(x(2), 0.5 * (x(0) + x(1)), 1e-14);
  }
  EXPECT_EQ(sum(comm, owned), GetParam().n);
  const Body whole(MPI_COMM_SELF, file_, GetParam().order);
  const auto all = edges_of_group(whole.mesh, whole.layout, test::group_named(whole.mesh, "edge"));
  expect_complete(edges.nodes, whole.layout, all.nodes);
  const auto corner = nodes_of_group(body_.mesh, layout_, test::group_named(body_.mesh, "corner"));
  EXPECT_EQ(sum(comm, static_cast<PetscInt64>(corner.size())), 1);
}

TEST_P(Selections, TheWholeSurfaceIsFoundOnce) {
  const auto everywhere = [](const Point&) { return true; };
  const auto facets = surface_facets(body_.mesh, layout_, everywhere);
  const int n = GetParam().n;
  const auto places = test::counted_everywhere(comm, owned_places(facets));
  EXPECT_EQ(static_cast<int>(places.size()), 12 * n * n);
  for (const auto& [place, count] : places) EXPECT_EQ(count, 1);
  if (GetParam().shape != Shape::curved) {
    EXPECT_NEAR(owned_area(facets), 6.0, 1e-12);
  }
  const Body whole(MPI_COMM_SELF, file_, GetParam().order);
  expect_complete(facets.nodes, whole.layout, surface_facets(whole.mesh, whole.layout, everywhere).nodes);
}

TEST_P(Selections, ARegionSelectsTheFacetsThatLieInItWhole) {
  if (GetParam().shape == Shape::curved) return;  // its faces are not planes
  const auto facets = surface_facets(body_.mesh, layout_, [](const Point& x) { return x[1] > 1.0 - 1e-9; });
  EXPECT_NEAR(owned_area(facets), 1.0, 1e-13);
  const auto none = surface_facets(body_.mesh, layout_, [](const Point& x) { return x[1] > 2.0; });
  EXPECT_EQ(none.size(), 0);
}

// The divergence theorem: int X . n dA over the surface is three times the volume, and int n dA vanishes, if all facets
// look outward. A straight-sided facet that looked inward would be missing twice.
TEST_P(Selections, SurfaceFacetsLookOutward) {
  const auto facets = surface_facets(body_.mesh, layout_, [](const Point&) { return true; });
  double volume = 0.0;
  Point sum_of_normals{};
  for (PetscInt f = 0; f < facets.size(); ++f) {
    EXPECT_TRUE(facets.is_outer[f]);
    if (!facets.is_owned[f]) continue;
    const auto nodes = nodes_of(facets, f);
    const auto [flux, normal] = GetParam().order == 1 ? flux_of<1>(layout_, nodes) : flux_of<2>(layout_, nodes);
    volume += flux / 3.0;
    for (int k = 0; k < 3; ++k) sum_of_normals[k] += normal[k];
  }
  EXPECT_NEAR(sum(comm, volume), GetParam().volume(), 1e-12);
  for (const double component : sum_of_normals) EXPECT_NEAR(sum(comm, component), 0.0, 1e-12);
}

// Those between the two halves of a body have no outside.
TEST(InnerFacets, AreNotOuter) {
  const Scratch scratch(comm);
  const auto file = scratch.file("cut.msh", [](const std::string& f) {
    BoxOptions options;
    options.cut = 1;
    write_box_msh(f, {1.0, 1.0, 1.0}, {2, 2, 2}, options);
  });
  const Body body(comm, file, 1);
  PetscInt64 num_inner = 0, num_outer = 0;
  for (const auto* name : {"cut", "tip"}) {
    const auto facets = facets_of_group(body.mesh, body.layout, test::group_named(body.mesh, name));
    ASSERT_EQ(facets.is_outer.size(), facets.is_owned.size());
    for (PetscInt f = 0; f < facets.size(); ++f) {
      if (facets.is_owned[f]) ++(facets.is_outer[f] ? num_outer : num_inner);
    }
  }
  EXPECT_EQ(sum(comm, num_inner), 8);
  EXPECT_EQ(sum(comm, num_outer), 8);
}

TEST_P(Selections, MidEdgeNodesFollowTheirEdges) {
  if (GetParam().order == 1 || GetParam().shape == Shape::curved) return;
  const auto facets = surface_facets(body_.mesh, layout_, [](const Point&) { return true; });
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = nodes_of(facets, f);
    for (int e = 0; e < 3; ++e) {
      const Point a = layout_.position(nodes[triangle_edges[e][0]]), b = layout_.position(nodes[triangle_edges[e][1]]);
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(layout_.position(nodes[3 + e])[k], 0.5 * (a[k] + b[k]), 1e-15);
    }
  }
}

TEST_P(Selections, CellsKnowTheirVolume) {
  const PhysicalGroup body = test::group_named(body_.mesh, "body");
  const auto once = volume_of_cells(body_.mesh, layout_, {body});
  EXPECT_EQ(once, std::vector<int>(static_cast<std::size_t>(layout_.num_local_cells), 0));
  const auto twice = volume_of_cells(body_.mesh, layout_, {body, body});
  EXPECT_EQ(twice, std::vector<int>(static_cast<std::size_t>(layout_.num_local_cells), -2));
  const auto none = volume_of_cells(body_.mesh, layout_, {});
  EXPECT_EQ(none, std::vector<int>(static_cast<std::size_t>(layout_.num_local_cells), -1));
}

}  // namespace
}  // namespace pliant::test_selection
