/// Work that one rank does for all. Its failures are raised on all ranks, so that none is left waiting.
#pragma once

#include <functional>
#include <span>
#include <string>
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

/// Concatenates the ranks' lists in rank order, on every rank. Collective.
std::vector<double> gathered(MPI_Comm comm, std::span<const double> mine);

}  // namespace pliant
