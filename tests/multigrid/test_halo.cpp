#include "multigrid/halo.hpp"

#include <gtest/gtest.h>

namespace pliant {
namespace {

/// PETSc's own communicator of all ranks.
struct OwnComm {
  OwnComm() { check(PetscCommDuplicate(PETSC_COMM_WORLD, &comm, nullptr)); }
  ~OwnComm() { (void)PetscCommDestroy(&comm); }
  OwnComm(const OwnComm&) = delete;
  OwnComm& operator=(const OwnComm&) = delete;
  int rank() const {
    int rank = 0;
    check_mpi(MPI_Comm_rank(comm, &rank));
    return rank;
  }
  int num_ranks() const {
    int number = 1;
    check_mpi(MPI_Comm_size(comm, &number));
    return number;
  }
  MPI_Comm comm = MPI_COMM_NULL;
};

/// Rank r owns r + 1 nodes; the ghosts of each are all that others own.
struct AllOfAll {
  OwnComm own;
  int rank = own.rank(), ranks = own.num_ranks();
  Halo halo{own.comm, rank + 1, ghosts()};
  PetscInt first() const { return rank * (rank + 1) / 2; }
  PetscInt all() const { return ranks * (ranks + 1) / 2; }
  std::vector<PetscInt> ghosts() const {
    std::vector<PetscInt> list;
    for (PetscInt node = 0; node < all(); ++node) {
      if (node < first() || node >= first() + rank + 1) list.push_back(node);
    }
    return list;
  }
};

TEST(Halo, CountsOwnNodesFirst) {
  const AllOfAll of;
  EXPECT_EQ(of.halo.num_global(), of.all());
  EXPECT_EQ(of.halo.first(), of.first());
  for (int node = 0; node < of.halo.num_local(); ++node) EXPECT_EQ(of.halo.local(of.halo.global(node)), node);
  EXPECT_EQ(of.halo.owner(of.first()), of.rank);
  EXPECT_EQ(of.halo.owner(of.all() - 1), of.ranks - 1);
}

TEST(Halo, GhostsTakeWhatOwnersHave) {
  const AllOfAll of;
  std::vector<double> x(2 * static_cast<std::size_t>(of.halo.num_local()), -1.0);
  for (std::size_t k = 0; k < 2 * static_cast<std::size_t>(of.halo.num_owned()); ++k) {
    x[k] = 2.0 * static_cast<double>(of.first()) + static_cast<double>(k);
  }
  of.halo.fetch(std::span(x), 2);
  for (int node = 0; node < of.halo.num_local(); ++node) {
    EXPECT_EQ(x[2 * static_cast<std::size_t>(node)], 2.0 * of.halo.global(node));
    EXPECT_EQ(x[2 * static_cast<std::size_t>(node) + 1], 2.0 * of.halo.global(node) + 1.0);
  }
}

TEST(Halo, OwnersSumWhatGhostsHave) {
  const AllOfAll of;
  std::vector<float> x;
  for (int node = 0; node < of.halo.num_local(); ++node) x.push_back(static_cast<float>(of.halo.global(node) + 1));
  of.halo.add_to_owners(std::span(x), 1);
  for (int node = 0; node < of.halo.num_owned(); ++node) {
    EXPECT_EQ(x[static_cast<std::size_t>(node)], static_cast<float>(of.ranks * (of.halo.global(node) + 1)));
  }
}

}  // namespace
}  // namespace pliant
