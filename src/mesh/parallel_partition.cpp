#include "mesh/parallel_partition.hpp"

#include "petsc/exchange.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <compare>
#include <utility>

#include <petscmat.h>

/// How to destroy one. In the namespace of PETSc's type, where Handle finds it.
static PetscErrorCode destroy(MatPartitioning* x) {
  return MatPartitioningDestroy(x);
}

namespace pliant {
namespace {

// Debian's PTScotch counts with 32 bits even where PETSc uses 64, and PETSc passes its numbers on unchecked.
#if defined(PETSC_HAVE_PTSCOTCH) && !defined(PETSC_USE_64BIT_INDICES)
constexpr const char* partitioner = MATPARTITIONINGPTSCOTCH;
#elif defined(PETSC_HAVE_PARMETIS)
constexpr const char* partitioner = MATPARTITIONINGPARMETIS;
#else
constexpr const char* partitioner = nullptr;
#endif

/// A facet of a cell by its vertices in ascending order.
struct Facet {
  std::array<std::int64_t, 3> vertices{};
  std::int64_t cell = 0;  // number in the whole mesh
};

/// Calls `both(a, b)` for the facets with the same vertices, `lone(facet)` for others.
template <class Pair, class Lone>
void match(std::vector<Facet>& facets, Pair both, Lone lone) {
  std::ranges::sort(facets, {}, [](const Facet& f) { return std::pair(f.vertices, f.cell); });
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (i + 1 < facets.size() && facets[i].vertices == facets[i + 1].vertices) {
      both(facets[i].cell, facets[i + 1].cell);
      ++i;
    } else {
      lone(facets[i]);
    }
  }
}

std::vector<Facet> facets_of(const CellBlock& block) {
  std::vector<Facet> facets;
  facets.reserve(4 * block.num_cells());
  for (std::size_t c = 0; c < block.num_cells(); ++c) {
    for (const auto& [i, j, k] : local_facets) {
      const std::int64_t* corners = &block.corners[4 * c];
      Facet& facet = facets.emplace_back(Facet{{corners[i], corners[j], corners[k]}, block.numbers[c]});
      std::ranges::sort(facet.vertices);
    }
  }
  return facets;
}

/// A cell of this rank, and one that shares a facet with it.
struct Neighbours {
  std::int64_t cell = 0, other = 0;
  auto operator<=>(const Neighbours&) const = default;
};

/// The cells that share a facet. Each facet with one cell here has a rank where both its cells are reported.
/// Collective.
std::vector<Neighbours> dual_graph(MPI_Comm comm, const CellBlock& block) {
  const auto size = static_cast<std::size_t>(num_ranks(comm));
  std::int64_t first_cell = block.numbers.empty() ? 0 : block.numbers.front();
  std::vector<std::int64_t> first_cells(size);
  const auto num_cells = static_cast<std::int64_t>(block.num_cells());
  check_mpi(MPI_Exscan(&num_cells, &first_cell, 1, MPI_INT64_T, MPI_SUM, comm));
  if (rank(comm) == 0) first_cell = 0;
  check_mpi(MPI_Allgather(&first_cell, 1, MPI_INT64_T, first_cells.data(), 1, MPI_INT64_T, comm));
  const auto rank_of = [&](std::int64_t cell) {
    return static_cast<std::size_t>(std::ranges::upper_bound(first_cells, cell) - first_cells.begin()) - 1;
  };
  std::vector<Neighbours> pairs;
  std::vector<std::vector<Facet>> reports(size);
  std::vector<Facet> facets = facets_of(block);
  match(
      facets,
      [&](std::int64_t a, std::int64_t b) {
        pairs.push_back({a, b});
        pairs.push_back({b, a});
      },
      [&](const Facet& facet) {
        const auto meeting = static_cast<std::uint64_t>(facet.vertices[0]) % size;
        reports[static_cast<std::size_t>(meeting)].push_back(facet);
      });
  facets = exchanged(comm, reports);
  std::vector<std::vector<Neighbours>> answers(size);
  match(
      facets,
      [&](std::int64_t a, std::int64_t b) {
        answers[rank_of(a)].push_back({a, b});
        answers[rank_of(b)].push_back({b, a});
      },
      [](const Facet&) {});
  for (const Neighbours& pair : exchanged(comm, answers)) pairs.push_back(pair);
  std::ranges::sort(pairs);
  return pairs;
}

}  // namespace

std::vector<PetscInt> partition_in_parallel(MPI_Comm comm, const CellBlock& block) {
  const auto num_cells = static_cast<PetscInt>(block.num_cells());
  if (partitioner == nullptr) return std::vector<PetscInt>(block.num_cells(), rank(comm));
  const std::vector<Neighbours> pairs = dual_graph(comm, block);
  // PETSc frees both.
  PetscInt *offsets = nullptr, *neighbours = nullptr;
  check(PetscMalloc1(num_cells + 1, &offsets));
  check(PetscMalloc1(pairs.size(), &neighbours));
  const std::int64_t first_cell = block.numbers.empty() ? 0 : block.numbers.front();
  std::size_t at = 0;
  for (PetscInt c = 0; c <= num_cells; ++c) {
    while (at < pairs.size() && pairs[at].cell < first_cell + c) ++at;
    offsets[c] = static_cast<PetscInt>(at);
  }
  std::ranges::transform(pairs, neighbours, [](const Neighbours& pair) { return static_cast<PetscInt>(pair.other); });
  PetscInt num_global = 0;
  check_mpi(MPI_Allreduce(&num_cells, &num_global, 1, MPIU_INT, MPI_SUM, comm));
  Handle<Mat> graph;
  check(MatCreateMPIAdj(comm, num_cells, num_global, offsets, neighbours, nullptr, graph.out()));
  Handle<MatPartitioning> partitioning;
  check(MatPartitioningCreate(comm, partitioning.out()));
  check(MatPartitioningSetAdjacency(partitioning.get(), graph.get()));
  check(MatPartitioningSetType(partitioning.get(), partitioner));
  check(MatPartitioningSetNParts(partitioning.get(), num_ranks(comm)));
  Handle<IS> parts;
  check(MatPartitioningApply(partitioning.get(), parts.out()));
  const PetscInt* part = nullptr;
  check(ISGetIndices(parts.get(), &part));
  std::vector<PetscInt> result(part, part + num_cells);
  check(ISRestoreIndices(parts.get(), &part));
  return result;
}

}  // namespace pliant
