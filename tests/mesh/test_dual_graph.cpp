// The cells that share facets, against a search of all pairs.
#include "mesh/dual_graph.hpp"

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace pliant::test_dual_graph {
namespace {

/// Distinct tetrahedra of random nodes: some share facets, some of these with more than one.
SerialMesh random_cells(unsigned seed) {
  std::mt19937 random(seed);
  constexpr PetscInt num_nodes = 9;
  SerialMesh mesh;
  mesh.coordinates.assign(3 * num_nodes, 0.0);
  std::vector<PetscInt> nodes(num_nodes);
  std::iota(nodes.begin(), nodes.end(), 0);
  std::set<std::set<PetscInt>> seen;
  while (mesh.num_cells() < 40) {
    std::ranges::shuffle(nodes, random);
    if (!seen.insert({nodes.begin(), nodes.begin() + 4}).second) continue;
    mesh.cells.insert(mesh.cells.end(), nodes.begin(), nodes.begin() + 4);
  }
  return mesh;
}

bool share_a_facet(const SerialMesh& mesh, std::size_t a, std::size_t b) {
  const auto has = [&](PetscInt node) {
    return std::find(&mesh.cells[4 * b], &mesh.cells[4 * b] + 4, node) != &mesh.cells[4 * b] + 4;
  };
  return std::count_if(&mesh.cells[4 * a], &mesh.cells[4 * a] + 4, has) == 3;
}

TEST(DualGraph, NeighboursAreTheCellsWithThreeCommonNodes) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const SerialMesh mesh = random_cells(seed);
    const DualGraph graph(mesh);
    std::size_t num_neighbours = 0;
    for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
      std::vector<idx_t> expected, found(graph.neighbours(c).begin(), graph.neighbours(c).end());
      for (std::size_t d = 0; d < mesh.num_cells(); ++d) {
        if (c != d && share_a_facet(mesh, c, d)) expected.push_back(static_cast<idx_t>(d));
      }
      std::ranges::sort(found);
      EXPECT_EQ(found, expected);
      num_neighbours += found.size();
    }
    EXPECT_GT(num_neighbours, 40u);
  }
}

}  // namespace
}  // namespace pliant::test_dual_graph
