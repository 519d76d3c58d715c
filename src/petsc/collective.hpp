/// Work that one rank does for all. Its failures are raised on all ranks, so that none is left waiting.
#pragma once

#include <cstddef>
#include <functional>
#include <numeric>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <petscsys.h>

namespace pliant {

/// Runs `work` on rank 0 only. If it throws there, every rank throws an exception of the same type (InputError with its
/// diagnostics, FileError; anything else as PetscFailure) with the same text. Collective.
void on_root(MPI_Comm comm, const std::function<void()>& work);

/// Runs `work` on every rank. If it throws on any rank, every rank throws the failure of the lowest such rank; `work`
/// itself must not be collective. Collective.
void on_every_rank(MPI_Comm comm, const std::function<void()>& work);

/// The text of rank 0 on every rank. Collective.
std::string broadcast(MPI_Comm comm, std::string text);

/// Sum, maximum and minimum over the ranks. Collective.
double sum(MPI_Comm comm, double x);
double maximum(MPI_Comm comm, double x);
double minimum(MPI_Comm comm, double x);
PetscInt64 sum(MPI_Comm comm, PetscInt64 x);
/// Logical or over the ranks. Collective.
bool any_rank(MPI_Comm comm, bool x);
/// Sums each number over the ranks. Collective.
void sum_in_place(MPI_Comm comm, std::span<double> values);

/// How long the lists of all ranks are. Collective.
std::vector<int> counts_of_ranks(MPI_Comm comm, std::size_t mine);
/// The ranks' bytes one after another into `all`, on every rank, of rows of so many bytes: `counts` of them.
/// Collective.
void gather_rows(MPI_Comm comm, std::size_t row, std::span<const std::byte> mine, std::span<const int> counts,
                 std::span<std::byte> all);

/// The ranks' lists of numbers, or of structs of them, one after another, on every rank. Collective.
template <std::ranges::contiguous_range List>
requires std::is_trivially_copyable_v<std::ranges::range_value_t<List>>
auto gathered(MPI_Comm comm, const List& mine) {
  using Row = std::ranges::range_value_t<List>;
  const std::vector<int> counts = counts_of_ranks(comm, std::ranges::size(mine));
  std::vector<Row> all(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  gather_rows(comm, sizeof(Row), std::as_bytes(std::span(mine)), counts, std::as_writable_bytes(std::span(all)));
  return all;
}

}  // namespace pliant
