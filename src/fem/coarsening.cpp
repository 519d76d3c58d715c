#include "fem/coarsening.hpp"

#include "fem/block_matrix.hpp"
#include "fem/element.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <array>
#include <cassert>
#include <vector>

namespace pliant {
namespace {

/// Global numbers of the vertices among themselves, owned ones first; -1 for mid-edge nodes.
struct VertexNumbers {
  PetscInt num_owned = 0;
  std::vector<PetscInt> of_node;  ///< per local node
};

/// The two vertices of each mid-edge node, as local nodes; {-1, -1} for vertices.
using EdgeEnds = std::vector<std::array<PetscInt, 2>>;

EdgeEnds edge_ends(const NodeLayout& layout) {
  EdgeEnds ends(static_cast<std::size_t>(layout.num_local_nodes), {-1, -1});
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    for (std::size_t e = 0; e < tet_edges.size(); ++e) {
      ends[nodes[4 + e]] = {nodes[tet_edges[e][0]], nodes[tet_edges[e][1]]};
    }
  }
  return ends;
}

VertexNumbers number_vertices(const NodeLayout& layout, const EdgeEnds& ends) {
  VertexNumbers numbers;
  numbers.of_node.assign(ends.size(), -1);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    if (ends[n][0] < 0) numbers.of_node[n] = numbers.num_owned++;
  }
  PetscInt first = 0;
  check_mpi(MPI_Exscan(&numbers.num_owned, &first, 1, MPIU_INT, MPI_SUM, layout.comm));
  const Handle<Vec> exchange = make_vector(layout);
  {
    const ArrayView values(exchange.get());
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      if (ends[n][0] < 0) values[3 * n] = numbers.of_node[n] += first;
    }
  }
  update_ghosts(exchange.get());
  const ConstGhostedView values(exchange.get());
  for (PetscInt n = layout.num_owned_nodes; n < layout.num_local_nodes; ++n) {
    if (ends[n][0] < 0) numbers.of_node[n] = static_cast<PetscInt>(values.span()[3 * n]);
  }
  return numbers;
}

}  // namespace

Coarsening make_coarsening(const NodeLayout& layout, std::span<const char> prescribed) {
  assert(layout.order == 2);
  const EdgeEnds ends = edge_ends(layout);
  const VertexNumbers vertices = number_vertices(layout, ends);
  Coarsening result;
  check(MatCreate(layout.comm, result.prolongation.out()));
  Mat P = result.prolongation.get();
  check(MatSetSizes(P, 3 * layout.num_owned_nodes, 3 * vertices.num_owned, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(P, MATMPIAIJ));  // as make_matrix does, on one rank too
  check(MatMPIAIJSetPreallocation(P, 2, nullptr, 2, nullptr));
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    for (int i = 0; i < 3; ++i) {
      const PetscInt row = 3 * layout.global_node(n) + i;
      if (ends[n][0] < 0) {
        check(MatSetValue(P, row, 3 * vertices.of_node[n] + i, 1.0, INSERT_VALUES));
        continue;
      }
      if (prescribed[3 * n + i]) continue;
      for (const PetscInt end : ends[n]) {
        if (!prescribed[3 * end + i]) check(MatSetValue(P, row, 3 * vertices.of_node[end] + i, 0.5, INSERT_VALUES));
      }
    }
  }
  check(MatAssemblyBegin(P, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(P, MAT_FINAL_ASSEMBLY));
  return result;
}

}  // namespace pliant
