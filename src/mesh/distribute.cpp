#include "mesh/distribute.hpp"

#include "mesh/tetrahedra_plex.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/global_order.hpp"
#include "petsc/plex.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

#include <petscdmplex.h>
#include <petscdmplextransform.h>

namespace pliant {
namespace {

constexpr PetscInt num_corners = 4;

/// The DMPlex of the cells as the ranks hold them, and the file's numbers of its local vertices, ascending.
struct Plex {
  Handle<DM> dm;
  std::vector<PetscInt> vertices;

  /// The DMPlex point of a vertex of the file.
  PetscInt vertex_point(PetscInt node) const {
    const auto found = std::lower_bound(vertices.begin(), vertices.end(), node);
    return stratum(dm.get(), 0).begin + static_cast<PetscInt>(found - vertices.begin());
  }
};

Handle<DM> plex_of_blocks(MPI_Comm comm, const MeshParts& parts, std::vector<PetscInt>& vertices) {
  Handle<DM> dm;
  const SerialMesh& mesh = parts.mesh;
  check(DMPlexCreateFromCellListParallelPetsc(comm, 3, static_cast<PetscInt>(mesh.num_cells()), parts.num_vertices,
                                              PETSC_DECIDE, num_corners, PETSC_TRUE, mesh.cells.data(), 3,
                                              mesh.coordinates.data(), nullptr, nullptr, dm.out()));
  // The vertices of the rank's cells in ascending order, as the call below creates them.
  vertices = mesh.cells;
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return dm;
}

Handle<DM> plex_of_one(MPI_Comm comm, const MeshParts& parts, std::vector<PetscInt>& vertices) {
  vertices.resize(static_cast<std::size_t>(parts.num_vertices));
  std::iota(vertices.begin(), vertices.end(), 0);
  return make_tetrahedra_plex(comm, parts.mesh, parts.num_vertices);
}

Plex build_plex(MPI_Comm comm, const MeshParts& parts) {
  Plex plex;
  const bool one_has_all = parts.held == MeshParts::Held::on_root || num_ranks(comm) == 1;
  plex.dm = one_has_all ? plex_of_one(comm, parts, plex.vertices) : plex_of_blocks(comm, parts, plex.vertices);
  // Cells that share a vertex are neighbours: assembling the rows of a vertex needs all of them.
  check(DMSetBasicAdjacency(plex.dm.get(), PETSC_FALSE, PETSC_TRUE));
  // Shared points are distributed over their ranks instead of all going to the highest one.
  check(DMPlexSetPartitionBalance(plex.dm.get(), PETSC_TRUE));
  return plex;
}

/// The point spanned by vertices, or -1 if the mesh has no such point.
PetscInt point_of(const Plex& plex, std::span<const PetscInt> nodes) {
  std::array<PetscInt, 3> vertices{};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < 0) return -1;
    vertices[i] = plex.vertex_point(nodes[i]);
  }
  if (nodes.size() == 1) return vertices[0];
  PetscInt count = 0;
  const PetscInt* joined = nullptr;
  check(DMPlexGetFullJoin(plex.dm.get(), static_cast<PetscInt>(nodes.size()), vertices.data(), &count, &joined));
  const PetscInt point = count == 1 ? joined[0] : -1;
  check(DMPlexRestoreJoin(plex.dm.get(), static_cast<PetscInt>(nodes.size()), vertices.data(), &count, &joined));
  return point;
}

std::vector<PetscInt> points_of(const Plex& plex, const SerialGroup& group, std::vector<std::string>& notices) {
  if (group.group.dimension == 3) return group.members;  // cells are numbered from 0, in the order of the list
  const auto size = static_cast<std::size_t>(group.group.dimension) + 1;
  std::vector<PetscInt> points;
  for (std::size_t i = 0; i + size <= group.members.size(); i += size) {
    const PetscInt p = point_of(plex, {&group.members[i], size});
    if (p >= 0) points.push_back(p);
  }
  notice_left_out(group, points.size(), notices);
  return points;
}

/// Sets the stratum of the label to exactly these points. Not collective.
void set_members(DM dm, const PhysicalGroup& group, std::vector<PetscInt> points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  DMLabel label = nullptr;
  check(DMGetLabel(dm, label_name(group).c_str(), &label));
  Handle<IS> is;
  check(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(points.size()), points.data(), PETSC_COPY_VALUES,
                        is.out()));
  check(DMLabelSetStratumIS(label, 1, is.get()));
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

/// One label per group; every rank has all labels, filled with the members that it holds. Collective.
void label_groups(const Plex& plex, const MeshParts& parts, const std::vector<PhysicalGroup>& groups,
                  std::vector<std::string>& notices) {
  DM dm = plex.dm.get();
  for (const auto& group : groups) check(DMCreateLabel(dm, label_name(group).c_str()));
  for (const auto& group : parts.mesh.groups) {
    std::vector<PetscInt> points = points_of(plex, group, notices);
    const bool can_be_shared = parts.held == MeshParts::Held::in_blocks && group.group.dimension < 3;
    set_members(dm, group.group, can_be_shared ? shared_members(dm, points) : std::move(points));
  }
}

/// Numbers attached to the points of one dimension during the distribution.
struct PointField {
  int dimension = 0;
  PetscInt components = 0;
  Handle<PetscSection> section;
  Handle<Vec> values;
};

PointField make_field(MPI_Comm comm, DM dm, int dimension, PetscInt components) {
  PointField field{dimension, components, {}, {}};
  const auto [begin, end] = stratum(dm, dimension);
  check(PetscSectionCreate(comm, field.section.out()));
  check(PetscSectionSetChart(field.section.get(), begin, end));
  for (PetscInt p = begin; p < end; ++p) check(PetscSectionSetDof(field.section.get(), p, components));
  check(PetscSectionSetUp(field.section.get()));
  check(VecCreate(comm, field.values.out()));
  check(VecSetSizes(field.values.get(), components * (end - begin), PETSC_DETERMINE));
  check(VecSetType(field.values.get(), VECSTANDARD));
  return field;
}

/// Edge points of a cell in the order of their mid-edge nodes.
std::array<std::pair<PetscInt, PetscInt>, 6> mid_nodes_of(DM dm, const SerialMesh& mesh, std::size_t cell) {
  std::array<std::pair<PetscInt, PetscInt>, 6> found{};
  std::size_t num_found = 0;
  const PetscInt vertices_begin = stratum(dm, 0).begin;
  const PointRange edges = stratum(dm, 1);
  PetscInt count = 0;
  PetscInt* closure = nullptr;
  check(DMPlexGetTransitiveClosure(dm, static_cast<PetscInt>(cell), PETSC_TRUE, &count, &closure));
  for (PetscInt i = 0; i < count; ++i) {
    const PetscInt p = closure[2 * i];
    if (p < edges.begin || p >= edges.end) continue;
    const PetscInt* ends = nullptr;
    check(DMPlexGetCone(dm, p, &ends));
    for (std::size_t e = 0; e < 6; ++e) {
      const PetscInt a = vertices_begin + mesh.cells[4 * cell + static_cast<std::size_t>(local_edges[e][0])];
      const PetscInt b = vertices_begin + mesh.cells[4 * cell + static_cast<std::size_t>(local_edges[e][1])];
      if (std::minmax(a, b) == std::minmax(ends[0], ends[1])) found[num_found++] = {p, mesh.mid_nodes[6 * cell + e]};
    }
  }
  check(DMPlexRestoreTransitiveClosure(dm, static_cast<PetscInt>(cell), PETSC_TRUE, &count, &closure));
  return found;
}

/// The positions of the mid-edge nodes.
PointField edge_field(MPI_Comm comm, DM dm, const SerialMesh& mesh) {
  PointField field = make_field(comm, dm, 1, 3);
  const PetscInt first = stratum(dm, 1).begin;
  const ArrayView values(field.values.get());
  for (std::size_t c = 0; c < mesh.mid_nodes.size() / 6; ++c) {
    for (const auto& [edge, mid_node] : mid_nodes_of(dm, mesh, c)) {
      for (PetscInt k = 0; k < 3; ++k) values[3 * (edge - first) + k] = mesh.node(mid_node)[k];
    }
  }
  return field;
}

/// All data of the cells, cell by cell, as they are distributed before the migration.
PointField cell_field(MPI_Comm comm, DM dm, const SerialMesh& mesh, const std::vector<CellField>& names) {
  PetscInt components = 0;
  for (const auto& data : names) components += data.components;
  PointField field = make_field(comm, dm, 3, components);
  const ArrayView values(field.values.get());
  for (std::size_t c = 0, at = 0; c < mesh.num_cells(); ++c) {
    for (const auto& data : mesh.cell_data) {
      const auto size = static_cast<std::size_t>(data.components);
      for (std::size_t k = 0; k < size; ++k) values[static_cast<PetscInt>(at++)] = data.values[size * c + k];
    }
  }
  return field;
}

/// The field on the mesh after the migration.
void migrate(MPI_Comm comm, DM dm, PetscSF migration, PointField& field) {
  PointField moved{field.dimension, field.components, {}, {}};
  check(PetscSectionCreate(comm, moved.section.out()));
  check(VecCreate(comm, moved.values.out()));
  check(DMPlexDistributeField(dm, migration, field.section.get(), field.values.get(), moved.section.get(),
                              moved.values.get()));
  field = std::move(moved);
}

std::vector<double> values_by_point(DM dm, const PointField& field) {
  const auto [begin, end] = stratum(dm, field.dimension);
  const ConstArrayView values(field.values.get());
  std::vector<double> result;
  result.reserve(static_cast<std::size_t>(field.components * (end - begin)));
  for (PetscInt p = begin; p < end; ++p) {
    PetscInt offset = 0;
    check(PetscSectionGetOffset(field.section.get(), p, &offset));
    for (PetscInt k = 0; k < field.components; ++k) result.push_back(values[offset + k]);
  }
  return result;
}

/// The field on the children of its cells: regular refinement numbers the eight of a cell consecutively.
PointField refined(MPI_Comm comm, DM coarse, DM fine, const PointField& field) {
  PointField result = make_field(comm, fine, 3, field.components);
  const std::vector<double> parents = values_by_point(coarse, field);
  const ArrayView values(result.values.get());
  const auto size = static_cast<std::size_t>(field.components);
  for (std::size_t i = 0; i < 8 * parents.size(); ++i) {
    values[static_cast<PetscInt>(i)] = parents[i / (8 * size) * size + i % size];
  }
  return result;
}

/// Numbers of vertices or cells from 0, in the order of the file.
PointField number_field(MPI_Comm comm, DM dm, int dimension, const std::vector<PetscInt>& numbers) {
  PointField field = make_field(comm, dm, dimension, 1);
  const ArrayView values(field.values.get());
  std::ranges::copy(numbers, values.span().begin());
  return field;
}

std::vector<PetscInt> numbers_of_cells(const MeshParts& parts) {
  std::vector<PetscInt> numbers(parts.mesh.num_cells());
  std::iota(numbers.begin(), numbers.end(), parts.first_cell);
  return numbers;
}

/// The numbers of the cells' children.
PointField refined_cell_numbers(MPI_Comm comm, DM coarse, DM fine, const PointField& numbers) {
  PointField result = refined(comm, coarse, fine, numbers);
  const ArrayView values(result.values.get());
  for (std::size_t i = 0; i < values.span().size(); ++i) {
    double& number = values.span()[i];
    number = 8.0 * number + static_cast<double>(i % 8);
  }
  return result;
}

/// Vertices of the refined mesh lie on vertices and edges of the coarse one; they are numbered in ascending order of
/// the numbers of the edge's ends.
PointField refined_vertex_numbers(MPI_Comm comm, DM coarse, DM fine, const PointField& numbers) {
  const std::vector<double> of_vertex = values_by_point(coarse, numbers);
  const PointRange vertices = stratum(coarse, 0), edges = stratum(coarse, 1), fine_vertices = stratum(fine, 0);
  // The transformation must be that of DMRefine: only it knows the images of points.
  Handle<DMPlexTransform> transform;
  check(DMPlexTransformCreate(comm, transform.out()));
  check(DMPlexTransformSetDM(transform.get(), coarse));
  check(DMPlexTransformSetType(transform.get(), DMPLEXREFINEREGULAR));
  check(DMPlexTransformSetUp(transform.get()));
  std::vector<EntryKey> keys(static_cast<std::size_t>(fine_vertices.end - fine_vertices.begin));
  const auto put = [&](DMPolytopeType from, PetscInt point, double a, double b) {
    PetscInt target = -1;
    check(DMPlexTransformGetTargetPoint(transform.get(), from, DM_POLYTOPE_POINT, point, 0, &target));
    keys[static_cast<std::size_t>(target - fine_vertices.begin)] = {static_cast<std::int64_t>(std::min(a, b)),
                                                                    static_cast<std::int64_t>(std::max(a, b))};
  };
  for (PetscInt v = vertices.begin; v < vertices.end; ++v) {
    const double number = of_vertex[static_cast<std::size_t>(v - vertices.begin)];
    put(DM_POLYTOPE_POINT, v, number, number);
  }
  for (PetscInt e = edges.begin; e < edges.end; ++e) {
    const PetscInt* ends = nullptr;
    check(DMPlexGetCone(coarse, e, &ends));
    put(DM_POLYTOPE_SEGMENT, e, of_vertex[static_cast<std::size_t>(ends[0] - vertices.begin)],
        of_vertex[static_cast<std::size_t>(ends[1] - vertices.begin)]);
  }
  const GlobalOrder order(comm, keys);
  PointField result = make_field(comm, fine, 0, 1);
  const ArrayView values(result.values.get());
  std::ranges::copy(order.row_of_entry(), values.span().begin());
  return result;
}

std::vector<std::int64_t> numbers_by_point(DM dm, const PointField& field) {
  const std::vector<double> values = values_by_point(dm, field);
  return {values.begin(), values.end()};
}

/// Splits the packed data into its fields.
void take_apart(const std::vector<double>& all, std::vector<CellField>& fields) {
  for (std::size_t at = 0; at < all.size();) {
    for (auto& data : fields) {
      for (int k = 0; k < data.components; ++k) data.values.push_back(all[at++]);
    }
  }
}

/// Assigns the cells to ranks by PTScotch or ParMETIS, whichever PETSc has. PTScotch is not reproducible: its partition
/// depends on the order in which messages arrive. Debian's build counts with 32 bits even where PETSc uses 64, and
/// PETSc passes its numbers on unchecked.
void partition_in_parallel(DM dm) {
#if defined(PETSC_HAVE_PTSCOTCH) && !defined(PETSC_USE_64BIT_INDICES)
  constexpr const char* kind = PETSCPARTITIONERPTSCOTCH;
#elif defined(PETSC_HAVE_PARMETIS)
  constexpr const char* kind = PETSCPARTITIONERPARMETIS;
#else
  // The file's order along a space-filling curve gives compact parts too.
  constexpr const char* kind = PETSCPARTITIONERSIMPLE;
#endif
  PetscPartitioner partitioner = nullptr;
  check(DMPlexGetPartitioner(dm, &partitioner));
  check(PetscPartitionerSetType(partitioner, kind));
}

/// Facets whose two cells are on different ranks. There must be no overlap yet. Collective.
long long num_cut_facets(MPI_Comm comm, DM dm) {
  const auto [begin, end] = stratum(dm, 2);
  PetscSF sf = nullptr;
  PetscInt num_leaves = 0;
  const PetscInt* leaves = nullptr;
  check(DMGetPointSF(dm, &sf));
  check(PetscSFGetGraph(sf, nullptr, &num_leaves, &leaves, nullptr));
  PetscInt64 count = 0;
  for (PetscInt i = 0; i < num_leaves; ++i) {
    const PetscInt p = leaves != nullptr ? leaves[i] : i;
    count += p >= begin && p < end ? 1 : 0;
  }
  return sum(comm, count);
}

/// Sends the cells to the ranks that METIS chose. No other rank holds cells yet.
void prescribe_partition(DM dm, const std::vector<PetscInt>& part, int size) {
  std::vector<PetscInt> sizes(static_cast<std::size_t>(size), 0);
  for (const PetscInt p : part) ++sizes[static_cast<std::size_t>(p)];
  std::vector<PetscInt> next(sizes.size(), 0);
  for (std::size_t p = 1; p < sizes.size(); ++p) next[p] = next[p - 1] + sizes[p - 1];
  std::vector<PetscInt> cells(part.size());
  for (std::size_t c = 0; c < part.size(); ++c) {
    cells[static_cast<std::size_t>(next[static_cast<std::size_t>(part[c])]++)] = static_cast<PetscInt>(c);
  }
  PetscPartitioner partitioner = nullptr;
  check(DMPlexGetPartitioner(dm, &partitioner));
  check(PetscPartitionerSetType(partitioner, PETSCPARTITIONERSHELL));
  check(PetscPartitionerShellSetPartition(partitioner, size, sizes.data(), cells.data()));
}

/// Refinement also marks the interior edges of facets, etc.; a label keeps only points of its group's own dimension.
/// (DMLabelFilter of PETSc 3.18 would be the call, but it leaves garbage in the stratum.)
void keep_own_dimension(DM dm, const std::vector<PhysicalGroup>& groups) {
  for (const auto& group : groups) {
    DMLabel label = nullptr;
    Handle<IS> marked;
    check(DMGetLabel(dm, label_name(group).c_str(), &label));
    check(DMLabelGetStratumIS(label, 1, marked.out()));
    if (!marked) continue;
    PetscInt count = 0;
    const PetscInt* p = nullptr;
    check(ISGetLocalSize(marked.get(), &count));
    check(ISGetIndices(marked.get(), &p));
    const PointRange own = stratum(dm, group.dimension);
    std::vector<PetscInt> kept;
    std::copy_if(p, p + count, std::back_inserter(kept), [&](PetscInt q) { return q >= own.begin && q < own.end; });
    check(ISRestoreIndices(marked.get(), &p));
    set_members(dm, group, std::move(kept));
  }
}

}  // namespace

void distribute(MPI_Comm comm, MeshParts&& parts, int refine, Mesh& result) {
  const int size = num_ranks(comm);
  const bool in_blocks = parts.held == MeshParts::Held::in_blocks;
  Plex plex = build_plex(comm, parts);
  label_groups(plex, parts, result.groups, result.report.notices);
  Handle<DM> dm = std::move(plex.dm);
  result.geometry_order = any_rank(comm, parts.mesh.geometry_order() == 2) ? 2 : 1;
  PointField midpoints, data;
  if (result.geometry_order == 2) midpoints = edge_field(comm, dm.get(), parts.mesh);
  const bool has_data = !result.cell_data.empty();
  if (has_data) data = cell_field(comm, dm.get(), parts.mesh, result.cell_data);
  PointField vertex_numbers = number_field(comm, dm.get(), 0, plex.vertices);
  PointField cell_numbers = number_field(comm, dm.get(), 3, numbers_of_cells(parts));
  if (size > 1 && in_blocks) partition_in_parallel(dm.get());
  if (size > 1 && !in_blocks) prescribe_partition(dm.get(), parts.part, size);
  parts = {};
  plex = {};
  const auto move_on = [&](DM from, Handle<DM> to, PetscSF migration) {
    migrate(comm, from, migration, vertex_numbers);
    migrate(comm, from, migration, cell_numbers);
    if (result.geometry_order == 2) migrate(comm, from, migration, midpoints);
    if (has_data) migrate(comm, from, migration, data);
    dm = std::move(to);
  };
  if (size > 1) {
    Handle<DM> distributed;
    Handle<PetscSF> migration;
    check(DMPlexDistribute(dm.get(), 0, migration.out(), distributed.out()));
    move_on(dm.get(), std::move(distributed), migration.get());
  }
  if (size > 1 && in_blocks) result.report.edge_cut = num_cut_facets(comm, dm.get());
  for (int i = 0; i < refine; ++i) {
    Handle<DM> fine;
    check(DMPlexSetRefinementUniform(dm.get(), PETSC_TRUE));
    check(DMRefine(dm.get(), comm, fine.out()));
    if (has_data) data = refined(comm, dm.get(), fine.get(), data);
    vertex_numbers = refined_vertex_numbers(comm, dm.get(), fine.get(), vertex_numbers);
    cell_numbers = refined_cell_numbers(comm, dm.get(), fine.get(), cell_numbers);
    dm = std::move(fine);
    keep_own_dimension(dm.get(), result.groups);
  }
  if (size > 1) {
    Handle<DM> overlapping;
    Handle<PetscSF> migration;
    check(DMSetBasicAdjacency(dm.get(), PETSC_FALSE, PETSC_TRUE));
    check(DMPlexDistributeOverlap(dm.get(), 1, migration.out(), overlapping.out()));
    move_on(dm.get(), std::move(overlapping), migration.get());
  }
  if (result.geometry_order == 2) result.edge_midpoints = values_by_point(dm.get(), midpoints);
  if (has_data) take_apart(values_by_point(dm.get(), data), result.cell_data);
  result.vertex_numbers = numbers_by_point(dm.get(), vertex_numbers);
  result.cell_numbers = numbers_by_point(dm.get(), cell_numbers);
  result.dm = std::move(dm);
}

}  // namespace pliant
