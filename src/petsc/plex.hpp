/// The few queries of a DMPlex that the other layers need.
#pragma once

#include "petsc/handle.hpp"

#include <algorithm>
#include <array>
#include <span>
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

/// The points on the boundary of a point, in PETSc's order. Not collective.
inline std::span<const PetscInt> cone(DM dm, PetscInt point) {
  PetscInt size = 0;
  const PetscInt* points = nullptr;
  check(DMPlexGetConeSize(dm, point, &size));
  check(DMPlexGetCone(dm, point, &points));
  return {points, static_cast<std::size_t>(size)};
}

/// The closure of a point of a mesh of tetrahedra: the point, then its facets, edges and vertices as far as it has
/// them, each once, in an order that depends on cones only. (DMPlexGetTransitiveClosure takes several times as long,
/// because it looks up the type of each point.) Not collective.
class Closure {
 public:
  Closure(DM dm, PetscInt point) {
    points_[size_++] = point;
    for (std::size_t i = 0; i < size_; ++i) {
      for (const PetscInt p : cone(dm, points_[i])) {
        if (std::find(begin(), end(), p) == end()) points_.at(size_++) = p;
      }
    }
  }
  const PetscInt* begin() const { return points_.data(); }
  const PetscInt* end() const { return points_.data() + size_; }
  PetscInt operator[](std::size_t i) const { return points_[i]; }
  std::size_t size() const { return size_; }

 private:
  std::array<PetscInt, 15> points_;  // of a tetrahedron
  std::size_t size_ = 0;
};

/// The two vertices of an edge. Not collective.
inline const PetscInt* ends_of_edge(DM dm, PetscInt edge) {
  return cone(dm, edge).data();
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
