/// What a test asks of a distributed mesh, the slow and plain way.
#pragma once

#include "mesh/mesh.hpp"
#include "petsc/array_view.hpp"

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <petscdmplex.h>

namespace pliant::test {

/// Points of one rank with their dimension, owner and middle.
class PlexPoints {
 public:
  explicit PlexPoints(DM dm) : dm_(dm) {
    check(DMPlexGetChart(dm, &begin_, &end_));
    for (int d = 0; d <= 3; ++d) check(DMPlexGetDepthStratum(dm, d, &strata_[d][0], &strata_[d][1]));
    owned_.assign(static_cast<std::size_t>(end_), true);
    PetscSF sf = nullptr;
    PetscInt num_leaves = 0;
    const PetscInt* leaves = nullptr;
    check(DMGetPointSF(dm, &sf));
    check(PetscSFGetGraph(sf, nullptr, &num_leaves, &leaves, nullptr));
    for (PetscInt i = 0; i < num_leaves; ++i) owned_[static_cast<std::size_t>(leaves ? leaves[i] : i)] = false;
  }

  PetscInt begin(int dimension) const { return strata_[dimension][0]; }
  PetscInt end(int dimension) const { return strata_[dimension][1]; }
  bool is_owned(PetscInt p) const { return owned_[static_cast<std::size_t>(p)]; }

  std::vector<PetscInt> closure(PetscInt p, int dimension) const { return transitive(p, dimension, PETSC_TRUE); }
  std::vector<PetscInt> star(PetscInt p, int dimension) const { return transitive(p, dimension, PETSC_FALSE); }

  std::vector<std::array<double, 3>> corners(PetscInt p) const {
    Vec x = nullptr;
    PetscSection section = nullptr;
    check(DMGetCoordinatesLocal(dm_, &x));
    check(DMGetCoordinateSection(dm_, &section));
    const ConstArrayView values(x);
    std::vector<std::array<double, 3>> result;
    for (const PetscInt v : closure(p, 0)) {
      PetscInt offset = 0;
      check(PetscSectionGetOffset(section, v, &offset));
      result.push_back({values[offset], values[offset + 1], values[offset + 2]});
    }
    return result;
  }

  std::array<double, 3> middle(PetscInt p) const {
    std::array<double, 3> m{};
    const auto x = corners(p);
    for (const auto& c : x) {
      for (std::size_t k = 0; k < 3; ++k) m[k] += c[k] / static_cast<double>(x.size());
    }
    return m;
  }

 private:
  std::vector<PetscInt> transitive(PetscInt p, int dimension, PetscBool use_cone) const {
    std::vector<PetscInt> result;
    PetscInt count = 0;
    PetscInt* points = nullptr;
    check(DMPlexGetTransitiveClosure(dm_, p, use_cone, &count, &points));
    for (PetscInt i = 0; i < count; ++i) {
      if (points[2 * i] >= begin(dimension) && points[2 * i] < end(dimension)) result.push_back(points[2 * i]);
    }
    check(DMPlexRestoreTransitiveClosure(dm_, p, use_cone, &count, &points));
    return result;
  }

  DM dm_;
  PetscInt begin_ = 0, end_ = 0;
  PetscInt strata_[4][2] = {};
  std::vector<bool> owned_;
};

/// A place, rounded so that it compares equal on every rank.
using Key = std::array<long long, 3>;
inline Key key_of(const std::array<double, 3>& x) {
  return {std::llround(1e7 * x[0]), std::llround(1e7 * x[1]), std::llround(1e7 * x[2])};
}

/// How often each key occurs on all ranks together. Collective.
inline std::map<Key, int> counted_everywhere(MPI_Comm comm, const std::vector<Key>& mine) {
  int size = 0, count = static_cast<int>(3 * mine.size());
  check_mpi(MPI_Comm_size(comm, &size));
  std::vector<int> counts(static_cast<std::size_t>(size)), offsets(static_cast<std::size_t>(size), 0);
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm));
  for (std::size_t r = 1; r < counts.size(); ++r) offsets[r] = offsets[r - 1] + counts[r - 1];
  std::vector<Key> all(static_cast<std::size_t>(offsets.back() + counts.back()) / 3);
  check_mpi(MPI_Allgatherv(mine.data(), count, MPI_LONG_LONG, all.data(), counts.data(), offsets.data(), MPI_LONG_LONG,
                           comm));
  std::map<Key, int> result;
  for (const auto& key : all) ++result[key];
  return result;
}

}  // namespace pliant::test
