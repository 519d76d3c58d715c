/// What nodes and pressures are called, whichever rank has them; and what the mesh is.
#pragma once

#include "fem/layout.hpp"
#include "fem/pressure_layout.hpp"
#include "mesh/mesh.hpp"
#include "petsc/global_order.hpp"

#include <cstdint>
#include <vector>

namespace pliant {

/// Numbers of the whole mesh, however it is spread (Mesh::vertex_numbers), ghosts included.
struct MeshNumbers {
  std::vector<std::int64_t> of_node;  ///< of local nodes that are vertices, -1 of others
  std::vector<std::int64_t> of_cell;  ///< of local cells
};

/// Not collective.
MeshNumbers mesh_numbers(const Mesh& mesh, const NodeLayout& layout);

/// Of the owned nodes: the numbers of the two vertices between which they lie, twice that of the vertex on which they
/// do. Not collective.
std::vector<EntryKey> node_keys(const Mesh& mesh, const NodeLayout& layout);

/// Of the owned pressures: the number of the vertex, and the body. Not collective.
std::vector<EntryKey> pressure_keys(const Mesh& mesh, const NodeLayout& layout, const PressureLayout& pressures);

/// A number that another mesh, or the same one with a node elsewhere, does not have (but by a chance of 1 in 2^64); the
/// same on any number of ranks. Collective.
std::uint64_t fingerprint(const Mesh& mesh, const NodeLayout& layout);

}  // namespace pliant
