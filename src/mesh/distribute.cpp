#include "mesh/distribute.hpp"

#include "mesh/cell_block.hpp"
#include "mesh/overlap.hpp"
#include "mesh/parallel_partition.hpp"
#include "mesh/refinement.hpp"
#include "mesh/tetrahedra_plex.hpp"
#include "petsc/collective.hpp"
#include "petsc/plex.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <iterator>

#include <petscdmplex.h>

namespace pliant {
namespace {

/// Numbers per cell: the file's data, and 18 for the nodes on its edges.
std::size_t width_of_values(const Mesh& mesh) {
  std::size_t width = mesh.geometry_order == 2 ? 18 : 0;
  for (const CellField& data : mesh.cell_data) width += static_cast<std::size_t>(data.components);
  return width;
}

/// The cells on the ranks that are to have them. Collective.
CellBlock on_their_ranks(MPI_Comm comm, CellBlock block, const std::vector<PetscInt>& part) {
  std::vector<std::vector<PetscInt>> cells(static_cast<std::size_t>(num_ranks(comm)));
  for (std::size_t c = 0; c < part.size(); ++c) {
    cells[static_cast<std::size_t>(part[c])].push_back(static_cast<PetscInt>(c));
  }
  std::vector<int> num_in;
  return sent(comm, block, cells, num_in);
}

/// The cells' vertices by their index in the block.
std::vector<PetscInt> local_corners(const CellBlock& block) {
  std::vector<PetscInt> corners;
  corners.reserve(block.corners.size());
  for (const std::int64_t v : block.corners) corners.push_back(static_cast<PetscInt>(index_of(block.vertices, v)));
  return corners;
}

/// The point spanned by a part of a local cell.
PetscInt point_of(DM dm, const CellMark& mark, std::span<const PetscInt> corners) {
  if (mark.dimension == 3) return mark.cell;
  if (mark.dimension == 2) return cone(dm, mark.cell)[static_cast<std::size_t>(3 - mark.part)];  // PETSc's order
  const auto vertex = [&](int corner) {
    return stratum(dm, 0).begin + corners[4 * static_cast<std::size_t>(mark.cell) + static_cast<std::size_t>(corner)];
  };
  const auto of_part = local_part(mark.dimension, static_cast<std::size_t>(mark.part));
  if (mark.dimension == 0) return vertex(of_part[0]);
  const Closure closure(dm, mark.cell);
  const auto edges = std::span(closure.begin(), closure.end()).subspan(5, 6);
  return joining_edge(dm, edges, vertex(of_part[0]), vertex(of_part[1]));
}

/// The points that any rank has listed, on every rank that has them. Collective.
std::vector<PetscInt> shared_members(DM dm, const std::vector<PetscInt>& points) {
  PetscInt num_points = 0;
  check(DMPlexGetChart(dm, nullptr, &num_points));
  std::vector<PetscInt> mine(static_cast<std::size_t>(num_points), 0);
  for (const PetscInt p : points) mine[static_cast<std::size_t>(p)] = 1;
  PetscSF sf = nullptr;
  check(DMGetPointSF(dm, &sf));
  std::vector<PetscInt> all = mine;
  check(PetscSFReduceBegin(sf, MPIU_INT, mine.data(), all.data(), MPI_MAX));
  check(PetscSFReduceEnd(sf, MPIU_INT, mine.data(), all.data(), MPI_MAX));
  mine = all;
  check(PetscSFBcastBegin(sf, MPIU_INT, mine.data(), all.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, MPIU_INT, mine.data(), all.data(), MPI_REPLACE));
  std::vector<PetscInt> result;
  for (PetscInt p = 0; p < num_points; ++p) {
    if (all[static_cast<std::size_t>(p)] != 0) result.push_back(p);
  }
  return result;
}

/// One label per group; every rank has all labels, filled with the members that it holds. `are_complete`: whether the
/// marks name each member for every cell that has it, not just for one. Collective.
void label_groups(const Mesh& mesh, std::span<const CellMark> marks, bool are_complete) {
  DM dm = mesh.dm.get();
  const std::vector<PhysicalGroup>& groups = mesh.groups;
  std::vector<std::vector<PetscInt>> points(groups.size());
  for (const CellMark& mark : marks) {
    points[static_cast<std::size_t>(mark.group)].push_back(point_of(dm, mark, mesh.corners));
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    std::vector<PetscInt>& members = points[g];
    if (!are_complete && groups[g].dimension < 3) members = shared_members(dm, members);
    std::ranges::sort(members);
    members.erase(std::unique(members.begin(), members.end()), members.end());
    const std::string name = label_name(groups[g]);
    DMLabel label = nullptr;
    check(DMCreateLabel(dm, name.c_str()));
    check(DMGetLabel(dm, name.c_str(), &label));
    Handle<IS> is;
    check(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(members.size()), members.data(), PETSC_COPY_VALUES,
                          is.out()));
    check(DMLabelSetStratumIS(label, 1, is.get()));
  }
}

/// Facets whose two cells are on different ranks. Collective.
long long num_cut_facets(MPI_Comm comm, DM dm, PetscInt num_own) {
  const PointRange facets = stratum(dm, 2);
  PetscInt64 count = 0;  // from both sides
  for (PetscInt f = facets.begin; f < facets.end; ++f) {
    PetscInt num_cells = 0;
    const PetscInt* cells = nullptr;
    check(DMPlexGetSupportSize(dm, f, &num_cells));
    check(DMPlexGetSupport(dm, f, &cells));
    count += num_cells == 2 && (cells[0] < num_own) != (cells[1] < num_own) ? 1 : 0;
  }
  return sum(comm, count) / 2;
}

/// Moves the values of the cells to the mesh, edge by edge and field by field.
void take_apart(const CellBlock& block, Mesh& mesh) {
  if (block.width == 0) return;
  DM dm = mesh.dm.get();
  const PointRange edges = stratum(dm, 1);
  if (mesh.geometry_order == 2) mesh.edge_midpoints.resize(3 * static_cast<std::size_t>(edges.size()));
  for (std::size_t c = 0; c < block.num_cells(); ++c) {
    auto value = block.values.begin() + static_cast<std::ptrdiff_t>(block.width * c);
    for (CellField& data : mesh.cell_data) {
      for (int k = 0; k < data.components; ++k) data.values.push_back(*value++);
    }
    if (mesh.geometry_order == 1) continue;
    for (std::int8_t e = 0; e < 6; ++e, value += 3) {
      const PetscInt edge = point_of(dm, {static_cast<PetscInt>(c), 0, 1, e}, mesh.corners);
      std::copy_n(value, 3, mesh.edge_midpoints.begin() + 3 * (edge - edges.begin));
    }
  }
}

}  // namespace

void distribute(MPI_Comm comm, MeshParts&& parts, int refine, Mesh& result) {
  const bool in_blocks = parts.held == MeshParts::Held::in_blocks;
  result.geometry_order = any_rank(comm, parts.mesh.geometry_order() == 2) ? 2 : 1;
  CellBlock block = block_of(parts, width_of_values(result), result.report.notices);
  if (num_ranks(comm) > 1) {
    const std::vector<PetscInt> part = in_blocks ? partition_in_parallel(comm, block) : std::move(parts.part);
    block = on_their_ranks(comm, std::move(block), part);
  }
  fetch_vertices(comm, {parts.mesh.coordinates.data(), 3 * static_cast<std::size_t>(parts.num_vertices)}, block);
  parts = {};
  for (int i = 0; i < refine; ++i) block = refined(comm, block);
  OverlappingCells cells = with_ghosts(comm, std::move(block));
  result.corners = local_corners(cells.block);
  result.dm = make_tetrahedra_plex(comm, result.corners, cells.block.coordinates);
  if (num_ranks(comm) > 1) set_owners(comm, result.dm.get(), cells);
  label_groups(result, cells.block.marks, !in_blocks);
  // Each facet was cut into four by each refinement.
  if (in_blocks) result.report.edge_cut = num_cut_facets(comm, result.dm.get(), cells.num_own) >> (2 * refine);
  take_apart(cells.block, result);
  result.vertex_numbers = std::move(cells.block.vertices);
  result.cell_numbers = std::move(cells.block.numbers);
}

}  // namespace pliant
