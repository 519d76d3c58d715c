/// The numbering of unknowns (degrees of freedom): the nodes of P1 or P2 tetrahedra, numbered for speed, and the cells
/// (elements) that this rank integrates.
#pragma once

#include "mesh/mesh.hpp"
#include "petsc/handle.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// Flat arrays extracted once from the distributed mesh; no loop above this layer walks the DMPlex, which can be freed
/// once the nodes, facets and cells of the input's names are found.
///
/// Nodes: every rank owns a contiguous block of global nodes. Local numbers 0 .. num_owned_nodes-1 are owned (reverse
/// Cuthill-McKee order), the ghosts follow in ascending global number.
/// Cells: owned ones first, then the ghost cells that touch an owned node, so that the rows of owned nodes are
/// complete without communication; sorted by their nodes.
struct NodeLayout {
  MPI_Comm comm = MPI_COMM_NULL;
  int order = 1;           ///< polynomial degree of the displacement
  int nodes_per_cell = 4;  ///< 4 or 10; corners, then mid-edge nodes in VTK's order

  PetscInt num_owned_nodes = 0;
  PetscInt num_local_nodes = 0;
  PetscInt first_global_node = 0;
  PetscInt num_global_nodes = 0;
  std::vector<PetscInt> ghost_global_nodes;  ///< of local nodes num_owned_nodes ..., ascending
  std::vector<PetscInt> node_of_point;       ///< local node of a DMPlex point, -1 if none; empty where the mesh is gone
  std::vector<std::int64_t>
      vertex_numbers;               ///< number in the whole mesh of local nodes that are vertices; -1 for others
  std::vector<double> coordinates;  ///< xyz of local nodes in the reference configuration [m]

  PetscInt num_owned_cells = 0;
  PetscInt num_local_cells = 0;
  std::int64_t num_global_cells = 0;
  std::vector<PetscInt> cell_nodes;        ///< local nodes, nodes_per_cell per cell, positively oriented
  std::vector<PetscInt> cell_points;       ///< DMPlex point per cell
  std::vector<std::int64_t> cell_numbers;  ///< number in the whole mesh, per cell
  std::vector<char> cell_is_affine;        ///< 0: the cell is curved by its mid-edge nodes

  PetscInt global_node(PetscInt local_node) const {
    return local_node < num_owned_nodes ? first_global_node + local_node
                                        : ghost_global_nodes[local_node - num_owned_nodes];
  }
  std::span<const PetscInt> nodes_of_cell(PetscInt cell) const {
    return {cell_nodes.data() + cell * nodes_per_cell, static_cast<std::size_t>(nodes_per_cell)};
  }
  std::array<double, 3> position(PetscInt local_node) const {
    return {coordinates[3 * local_node], coordinates[3 * local_node + 1], coordinates[3 * local_node + 2]};
  }
};

/// Numbers the nodes of the elements of the given order (1 or 2). Second-order geometry curves P2 elements only. Throws
/// InputError if there are more unknowns than the integer type can count. Collective.
NodeLayout make_layout(const Mesh& mesh, int order);

/// Sets `cell_is_affine` from the coordinates. Not collective.
void mark_bent_cells(NodeLayout& layout);

/// The largest cell of a body, of several the one with the lowest number in the whole mesh; -1 on ranks that do not
/// have it. All that own one of its nodes do. `body_of_cell`: per local cell. Collective.
PetscInt largest_cell_of(const NodeLayout& layout, const std::vector<int>& body_of_cell, int body);

/// A vector of three entries per node with ghosts (petsc/ghosted.hpp), zero. Collective.
Handle<Vec> make_vector(const NodeLayout& layout);

/// Nodes that share a cell, as compressed rows (each row contains the node itself; unsorted).
struct NodeGraph {
  std::vector<PetscInt> offsets;     ///< num_rows + 1
  std::vector<PetscInt> neighbours;  ///< local nodes
};

/// The rows 0 .. num_rows-1 of the graph of `cell_nodes` (nodes numbered below num_nodes).
NodeGraph node_graph(std::span<const PetscInt> cell_nodes, int nodes_per_cell, PetscInt num_nodes, PetscInt num_rows);

}  // namespace pliant
