/// The few queries of a DMPlex that the other layers need.
#pragma once

#include "petsc/handle.hpp"

#include <vector>

#include <petscdmplex.h>

namespace pliant {

/// A half-open range of DMPlex points.
struct PointRange {
  PetscInt begin = 0;
  PetscInt end = 0;
  bool contains(PetscInt point) const { return point >= begin && point < end; }
  PetscInt size() const { return end - begin; }
};

/// Points of a depth: 0 vertices, 1 edges, 2 facets, 3 cells of an interpolated mesh. Not collective.
inline PointRange stratum(DM dm, PetscInt depth) {
  PointRange range;
  check(DMPlexGetDepthStratum(dm, depth, &range.begin, &range.end));
  return range;
}

/// One flag per local point: 1 if another rank owns it. Not collective.
inline std::vector<char> ghost_points(DM dm) {
  PetscInt num_points = 0;
  check(DMPlexGetChart(dm, nullptr, &num_points));
  std::vector<char> is_ghost(num_points, 0);
  PetscSF sf = nullptr;
  check(DMGetPointSF(dm, &sf));
  PetscInt num_leaves = 0;
  const PetscInt* leaves = nullptr;
  check(PetscSFGetGraph(sf, nullptr, &num_leaves, &leaves, nullptr));
  for (PetscInt i = 0; i < num_leaves; ++i) is_ghost[leaves != nullptr ? leaves[i] : i] = 1;
  return is_ghost;
}

/// Calls `visit(q)` for every point q of the closure of `point`. Not collective.
template <class Visit>
void for_each_in_closure(DM dm, PetscInt point, Visit visit) {
  PetscInt size = 0;
  PetscInt* closure = nullptr;
  check(DMPlexGetTransitiveClosure(dm, point, PETSC_TRUE, &size, &closure));
  for (PetscInt i = 0; i < size; ++i) visit(closure[2 * i]);
  check(DMPlexRestoreTransitiveClosure(dm, point, PETSC_TRUE, &size, &closure));
}

/// The two vertices of an edge. Not collective.
inline const PetscInt* ends_of_edge(DM dm, PetscInt edge) {
  const PetscInt* ends = nullptr;
  check(DMPlexGetCone(dm, edge, &ends));
  return ends;
}

/// The edge among `edges` that joins vertices a and b, or -1 if none does. Not collective.
template <class Edges>
PetscInt joining_edge(DM dm, const Edges& edges, PetscInt a, PetscInt b) {
  for (const PetscInt edge : edges) {
    if (edge < 0) continue;
    const PetscInt* ends = ends_of_edge(dm, edge);
    if ((ends[0] == a && ends[1] == b) || (ends[0] == b && ends[1] == a)) return edge;
  }
  return -1;
}

}  // namespace pliant
