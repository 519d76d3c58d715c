/// Cells of a rank with all that belongs to them, on their way from the file to the distributed mesh.
#pragma once

#include "mesh/distribute.hpp"

#include <algorithm>
#include <cstdint>

namespace pliant {

/// That a part of a cell is a member of a group.
struct CellMark {
  PetscInt cell = 0;  ///< of the block
  int group = 0;      ///< index in Mesh::groups
  std::int8_t dimension = 0;
  std::int8_t part = 0;  ///< as of local_part
};

/// Cells and vertices have the numbers of the whole mesh.
struct CellBlock {
  std::vector<std::int64_t> corners;   ///< numbers of four vertices per cell
  std::vector<std::int64_t> numbers;   ///< of the cells
  std::size_t width = 0;               ///< of `values`; the same on every rank
  std::vector<double> values;          ///< `width` per cell, one kind after another
  std::vector<CellMark> marks;         ///< of the cells' parts, by ascending cells
  std::vector<std::int64_t> vertices;  ///< numbers of the cells' vertices, ascending
  std::vector<double> coordinates;     ///< xyz of each of `vertices` [m]

  std::size_t num_cells() const { return numbers.size(); }
};

/// The cells of `parts` as its rank holds them, without vertices; `values`: the numbers of the file's cell data, then
/// the xyz of the six nodes on the edges (local_edges) if the geometry has the second order. Frees the cells of
/// `parts`, notices on rank 0 what groups have besides. Not collective.
CellBlock block_of(MeshParts& parts, std::size_t width, std::vector<std::string>& notices);

/// The cells that come to this rank if `cells[r]` of the block go to rank r, those of rank 0 first; `num_in[r]` are
/// from rank r. They have no vertices. Collective.
CellBlock sent(MPI_Comm comm, const CellBlock& block, const std::vector<std::vector<PetscInt>>& cells,
               std::vector<int>& num_in);

/// Fills `vertices` and `coordinates`. `held`: positions of the vertices that this rank has, in rank order those of the
/// whole mesh. Collective.
void fetch_vertices(MPI_Comm comm, std::span<const double> held, CellBlock& block);

/// The block's index of a vertex that it has.
inline std::size_t index_of(std::span<const std::int64_t> vertices, std::int64_t vertex) {
  return static_cast<std::size_t>(std::ranges::lower_bound(vertices, vertex) - vertices.begin());
}

}  // namespace pliant
