/// The dual graph of a mesh (tetrahedra that share facets): connectivity, and the partition over ranks.
#pragma once

#include "mesh/report.hpp"
#include "mesh/serial_mesh.hpp"

#include <span>
#include <vector>

#include <metis.h>

namespace pliant {

/// What two neighbours have in common: as many nodes.
enum class CommonNodes { of_facets = 3, of_edges = 2 };

/// Cells as graph vertices, shared facets as edges, in compressed rows.
class DualGraph {
 public:
  explicit DualGraph(const SerialMesh& mesh, CommonNodes common = CommonNodes::of_facets);

  std::size_t num_cells() const { return num_cells_; }
  std::span<const idx_t> neighbours(std::size_t cell) const {
    return {adjacency_.data() + offsets_[cell], adjacency_.data() + offsets_[cell + 1]};
  }

  /// The part of each cell: `num_parts` balanced parts, none empty, contiguous if the mesh is; deterministic. Counts
  /// the cut facets in `edge_cut`. Needs num_cells >= num_parts.
  std::vector<PetscInt> partition(int num_parts, long long& edge_cut) const;

  /// Number of components that no shared facet connects.
  std::size_t num_components() const;

 private:
  std::size_t num_cells_ = 0;
  // METIS does not change them, although it takes them as if it did.
  mutable std::vector<idx_t> offsets_, adjacency_;
};

/// What is not worth a notice.
struct AddedParts {
  std::size_t num_parts = 0;                       ///< parts that stand for bodies
  std::size_t first_of_rods = 0, num_of_rods = 0;  ///< cells of rods and shells, which no facets
                                                   ///< connect
};

/// Rejects tetrahedra that overlap at a common facet (both on the same side of it, or three sharing one). Adds notices
/// of disconnected parts, and of parts that only an edge or a node connects. Throws MeshDefect. Not collective.
void check_connections(const SerialMesh& mesh, const DualGraph& graph, PetscInt num_vertices, const AddedParts& added,
                       MeshReport& report);

}  // namespace pliant
