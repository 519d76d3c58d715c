/// The columns from which a study takes numbers, looked for before its runs.
#pragma once

#include "input/config.hpp"
#include "study/run_numbers.hpp"

#include <span>

#include <petscsys.h>

namespace pliant {

/// Throws InputError, at `--result`, for a number of a column that no run of these inputs has. Builds models only where
/// the inputs alone do not show that the column is there; inputs whose model cannot be built have no columns.
/// Collective.
void require_columns(MPI_Comm comm, std::span<const RunNumber> numbers, std::span<const Config> inputs);

}  // namespace pliant
