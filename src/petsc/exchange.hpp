/// Lists that every rank sends to every other.
#pragma once

#include "petsc/check.hpp"

#include <numeric>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// `out[r]`: what goes to rank r. Returns what has come from rank 0, then from rank 1, ... T is trivially copyable.
/// Collective.
template <class T>
std::vector<T> exchanged(MPI_Comm comm, const std::vector<std::vector<T>>& out) {
  const std::size_t num_ranks = out.size();
  std::vector<int> num_out(num_ranks), num_in(num_ranks), out_at(num_ranks, 0), in_at(num_ranks, 0);
  std::vector<T> sent;
  for (std::size_t r = 0; r < num_ranks; ++r) {
    num_out[r] = static_cast<int>(out[r].size());
    sent.insert(sent.end(), out[r].begin(), out[r].end());
  }
  check_mpi(MPI_Alltoall(num_out.data(), 1, MPI_INT, num_in.data(), 1, MPI_INT, comm));
  std::partial_sum(num_out.begin(), num_out.end() - 1, out_at.begin() + 1);
  std::partial_sum(num_in.begin(), num_in.end() - 1, in_at.begin() + 1);
  std::vector<T> received(static_cast<std::size_t>(in_at.back()) + static_cast<std::size_t>(num_in.back()));
  MPI_Datatype type = MPI_DATATYPE_NULL;
  check_mpi(MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type));
  check_mpi(MPI_Type_commit(&type));
  check_mpi(MPI_Alltoallv(sent.data(), num_out.data(), out_at.data(), type, received.data(), num_in.data(),
                          in_at.data(), type, comm));
  check_mpi(MPI_Type_free(&type));
  return received;
}

}  // namespace pliant
