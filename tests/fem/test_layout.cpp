// Who owns which node, what the ghosts are called, where the nodes are.
#include "fem/body.hpp"
#include "fem/element.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace pliant::test_layout {
namespace {

using test::Body;
using test::BodySpec;
using test::Key;
using test::key_of;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

class Layouts : public test::OnBodies {
 protected:
};

// n = 1: six cells on up to three ranks, so that a rank may own next to nothing.
INSTANTIATE_TEST_SUITE_P(Bodies, Layouts,
                         ::testing::Values(BodySpec{1, Shape::straight, 1}, BodySpec{2, Shape::straight, 1},
                                           BodySpec{1, Shape::jittered, 4}, BodySpec{2, Shape::jittered, 3},
                                           BodySpec{1, Shape::curved, 2}, BodySpec{2, Shape::curved, 3}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Layouts, CountsAreThoseOfTheBox) {
  const auto [order, shape, n] = GetParam();
  const PetscInt along = order * n + 1;  // the middles of Kuhn's edges complete the lattice of half the spacing
  EXPECT_EQ(layout_.num_global_nodes, along * along * along);
  EXPECT_EQ(layout_.num_global_cells, 6 * n * n * n);
  EXPECT_EQ(sum(comm, PetscInt64{layout_.num_owned_nodes}), layout_.num_global_nodes);
  EXPECT_EQ(sum(comm, PetscInt64{layout_.num_owned_cells}), layout_.num_global_cells);
  EXPECT_EQ(layout_.cell_nodes.size(), static_cast<std::size_t>(layout_.num_local_cells * layout_.nodes_per_cell));
  EXPECT_EQ(layout_.nodes_per_cell, order == 1 ? 4 : 10);
  EXPECT_LE(layout_.num_owned_cells, layout_.num_local_cells);
}

TEST_P(Layouts, OwnedNodesAreContiguousAndGhostsAscend) {
  PetscInt before = 0;
  check_mpi(MPI_Scan(&layout_.num_owned_nodes, &before, 1, MPIU_INT, MPI_SUM, comm));
  EXPECT_EQ(layout_.first_global_node, before - layout_.num_owned_nodes);
  const auto& ghosts = layout_.ghost_global_nodes;
  EXPECT_EQ(layout_.num_local_nodes - layout_.num_owned_nodes, static_cast<PetscInt>(ghosts.size()));
  EXPECT_TRUE(std::is_sorted(ghosts.begin(), ghosts.end()));
  EXPECT_EQ(std::set<PetscInt>(ghosts.begin(), ghosts.end()).size(), ghosts.size());
  for (const PetscInt g : ghosts) {
    EXPECT_TRUE(g < layout_.first_global_node || g >= before);
    EXPECT_LT(g, layout_.num_global_nodes);
  }
}

TEST_P(Layouts, GhostsStandWhereTheirOwnersSay) {
  const Handle<Vec> places = make_vector(layout_);
  PetscInt global_size = 0;
  check(VecGetSize(places.get(), &global_size));
  EXPECT_EQ(global_size, 3 * layout_.num_global_nodes);
  {
    const ArrayView x(places.get());
    std::copy_n(layout_.coordinates.begin(), x.span().size(), x.span().begin());
  }
  update_ghosts(places.get());
  const ConstGhostedView x(places.get());
  ASSERT_EQ(x.span().size(), layout_.coordinates.size());
  for (std::size_t i = 0; i < layout_.coordinates.size(); ++i) EXPECT_EQ(x.span()[i], layout_.coordinates[i]);
}

TEST_P(Layouts, NodesNumberTheirPointsOnce) {
  std::vector<int> uses(static_cast<std::size_t>(layout_.num_local_nodes), 0);
  for (const PetscInt n : layout_.node_of_point) {
    ASSERT_LT(n, layout_.num_local_nodes);
    if (n >= 0) ++uses[static_cast<std::size_t>(n)];
  }
  EXPECT_TRUE(std::all_of(uses.begin(), uses.end(), [](int u) { return u == 1; }));
  std::vector<Key> owned;
  for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) owned.push_back(key_of(layout_.position(a)));
  const auto owners = test::counted_everywhere(comm, owned);
  EXPECT_EQ(static_cast<PetscInt>(owners.size()), layout_.num_global_nodes);
  for (const auto& [place, count] : owners) EXPECT_EQ(count, 1);
}

// Against the same mesh on one rank: what the rows of owned nodes rely on.
TEST_P(Layouts, EveryCellOfAnOwnedNodeIsHere) {
  const Body whole(MPI_COMM_SELF, file_, GetParam().order);
  const auto cells_around = [](const NodeLayout& layout) {
    std::map<Key, int> count;
    for (const PetscInt n : layout.cell_nodes) ++count[key_of(layout.position(n))];
    return count;
  };
  EXPECT_EQ(whole.layout.num_global_nodes, layout_.num_global_nodes);
  EXPECT_EQ(whole.layout.num_global_cells, layout_.num_global_cells);
  EXPECT_EQ(whole.layout.num_local_cells, whole.layout.num_owned_cells);
  const auto all = cells_around(whole.layout);
  const auto here = cells_around(layout_);
  for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
    const Key key = key_of(layout_.position(a));
    ASSERT_TRUE(all.contains(key));
    EXPECT_EQ(here.at(key), all.at(key));
  }
  // Ghost cells are there for an owned node's sake only.
  for (PetscInt c = layout_.num_owned_cells; c < layout_.num_local_cells; ++c) {
    const auto nodes = layout_.nodes_of_cell(c);
    EXPECT_TRUE(std::any_of(nodes.begin(), nodes.end(), [&](PetscInt n) { return n < layout_.num_owned_nodes; }));
  }
}

TEST_P(Layouts, CellsArePositivelyOrientedWithMiddlesOnTheirEdges) {
  const bool is_curved = GetParam().shape == Shape::curved;
  for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
    const auto nodes = layout_.nodes_of_cell(c);
    std::array<Point, 4> d;
    for (int a = 0; a < 4; ++a) d[a] = layout_.position(nodes[a]);
    for (int a = 1; a < 4; ++a) {
      for (int k = 0; k < 3; ++k) d[a][k] -= d[0][k];
    }
    EXPECT_GT(d[1][0] * (d[2][1] * d[3][2] - d[2][2] * d[3][1]) - d[1][1] * (d[2][0] * d[3][2] - d[2][2] * d[3][0]) +
                  d[1][2] * (d[2][0] * d[3][1] - d[2][1] * d[3][0]),
              0.0);
    bool is_affine = true;
    for (int e = 0; e < (GetParam().order == 2 ? 6 : 0); ++e) {
      const Point a = layout_.position(nodes[tet_edges[e][0]]), b = layout_.position(nodes[tet_edges[e][1]]);
      const Point m = layout_.position(nodes[4 + e]);
      Point chord, expected;
      for (int k = 0; k < 3; ++k) chord[k] = expected[k] = 0.5 * (a[k] + b[k]);
      if (is_curved) {
        // `bent` maps straight lattice edges: undo it at the ends (y, then z, then x), halve, and bend again.
        const auto unbent = [](const Point& x) {
          Point u = x;
          for (int i = 0; i < 60; ++i) {
            const Point at = test::bent(u);
            for (int k = 0; k < 3; ++k) u[k] += x[k] - at[k];
          }
          return u;
        };
        const Point p = unbent(a), q = unbent(b);
        expected = test::bent({0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.5 * (p[2] + q[2])});
      }
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(m[k], expected[k], 1e-12);
        is_affine = is_affine && std::abs(m[k] - chord[k]) < 1e-9;
      }
    }
    EXPECT_EQ(layout_.cell_is_affine[c] != 0, is_affine);
  }
}

// Reverse Cuthill-McKee order: no cell spans more than a few layers of the cube's nodes.
TEST_P(Layouts, NeighboursAreCloseInNumber) {
  const int along = GetParam().order * GetParam().n + 1;
  for (PetscInt c = 0; c < layout_.num_local_cells; ++c) {
    PetscInt low = layout_.num_local_nodes, high = -1;
    for (const PetscInt n : layout_.nodes_of_cell(c)) {
      if (n >= layout_.num_owned_nodes) continue;
      low = std::min(low, n);
      high = std::max(high, n);
    }
    EXPECT_LE(high - low, 3 * GetParam().order * along * along);
  }
}

}  // namespace
}  // namespace pliant::test_layout
