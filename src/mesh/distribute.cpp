#include "mesh/distribute.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <algorithm>

#include <petscdmplex.h>

namespace pliant {
namespace {

constexpr PetscInt num_corners = 4;

struct Stratum {
  PetscInt begin = 0;
  PetscInt end = 0;
};

Stratum stratum(DM dm, int dimension) {
  Stratum s;
  check(DMPlexGetDepthStratum(dm, dimension, &s.begin, &s.end));
  return s;
}

Handle<DM> build_plex(MPI_Comm comm, const MeshParts& parts) {
  Handle<DM> dm;
  const SerialMesh& mesh = parts.mesh;
  check(DMPlexCreateFromCellListPetsc(comm, 3, static_cast<PetscInt>(mesh.num_cells()), parts.num_vertices, num_corners,
                                      PETSC_TRUE, mesh.cells.data(), 3, mesh.coordinates.data(), dm.out()));
  // Cells that share a vertex are neighbours: what the assembly of a vertex's rows needs.
  check(DMSetBasicAdjacency(dm.get(), PETSC_FALSE, PETSC_TRUE));
  // Shared points are spread over their ranks instead of going all to the highest one.
  check(DMPlexSetPartitionBalance(dm.get(), PETSC_TRUE));
  return dm;
}

/// The point spanned by vertices, or -1 if the mesh has no such point.
PetscInt point_of(DM dm, std::span<const PetscInt> nodes, PetscInt vertices_begin) {
  std::array<PetscInt, 3> vertices{};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < 0) return -1;
    vertices[i] = vertices_begin + nodes[i];
  }
  if (nodes.size() == 1) return vertices[0];
  PetscInt count = 0;
  const PetscInt* joined = nullptr;
  check(DMPlexGetFullJoin(dm, static_cast<PetscInt>(nodes.size()), vertices.data(), &count, &joined));
  const PetscInt point = count == 1 ? joined[0] : -1;
  check(DMPlexRestoreJoin(dm, static_cast<PetscInt>(nodes.size()), vertices.data(), &count, &joined));
  return point;
}

std::vector<PetscInt> points_of(DM dm, const SerialGroup& group, std::vector<std::string>& notices) {
  if (group.group.dimension == 3) return group.members;  // cells are numbered from 0, in the order of the list
  const PetscInt vertices_begin = stratum(dm, 0).begin;
  const auto size = static_cast<std::size_t>(group.group.dimension) + 1;
  std::vector<PetscInt> points;
  std::size_t off_mesh = 0;
  for (std::size_t i = 0; i + size <= group.members.size(); i += size) {
    const PetscInt p = point_of(dm, {&group.members[i], size}, vertices_begin);
    if (p >= 0) {
      points.push_back(p);
    } else {
      ++off_mesh;
    }
  }
  if (off_mesh > 0) {
    notices.push_back(describe(group.group) + ": " + std::to_string(off_mesh) + " of its " +
                      std::to_string(group.members.size() / size) +
                      " elements are not part of a tetrahedron and were left out");
  }
  return points;
}

/// One label per group; every rank has all of them, rank 0 fills them.
void label_groups(DM dm, const MeshParts& parts, const std::vector<PhysicalGroup>& groups,
                  std::vector<std::string>& notices) {
  for (const auto& group : groups) check(DMCreateLabel(dm, label_name(group).c_str()));
  for (const auto& group : parts.mesh.groups) {
    std::vector<PetscInt> points = points_of(dm, group, notices);
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    DMLabel label = nullptr;
    check(DMGetLabel(dm, label_name(group.group).c_str(), &label));
    Handle<IS> is;
    check(ISCreateGeneral(PETSC_COMM_SELF, static_cast<PetscInt>(points.size()), points.data(), PETSC_COPY_VALUES,
                          is.out()));
    check(DMLabelSetStratumIS(label, 1, is.get()));
  }
}

/// Hands the cells to the ranks that METIS chose. No other rank holds cells yet.
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

/// Refined facets also mark their inner edges, and so on: a label keeps the points of its group's own dimension.
void keep_own_dimension(DM dm, const std::vector<PhysicalGroup>& groups) {
  for (const auto& group : groups) {
    DMLabel label = nullptr;
    check(DMGetLabel(dm, label_name(group).c_str(), &label));
    const Stratum s = stratum(dm, group.dimension);
    check(DMLabelFilter(label, s.begin, s.end));
  }
}

}  // namespace

void distribute(MPI_Comm comm, MeshParts&& parts, int refine, Mesh& result) {
  Handle<DM> dm = build_plex(comm, parts);
  label_groups(dm.get(), parts, result.groups, result.report.notices);
  const int size = num_ranks(comm);
  if (size > 1) prescribe_partition(dm.get(), parts.part, size);
  parts = {};
  if (size > 1) {
    Handle<DM> distributed;
    check(DMPlexDistribute(dm.get(), 0, nullptr, distributed.out()));
    dm = std::move(distributed);
  }
  for (int i = 0; i < refine; ++i) {
    Handle<DM> refined;
    check(DMPlexSetRefinementUniform(dm.get(), PETSC_TRUE));
    check(DMRefine(dm.get(), comm, refined.out()));
    dm = std::move(refined);
    keep_own_dimension(dm.get(), result.groups);
  }
  if (size > 1) {
    Handle<DM> overlapping;
    check(DMSetBasicAdjacency(dm.get(), PETSC_FALSE, PETSC_TRUE));
    check(DMPlexDistributeOverlap(dm.get(), 1, nullptr, overlapping.out()));
    dm = std::move(overlapping);
  }
  result.dm = std::move(dm);
}

}  // namespace pliant
