/// The picture of bodies that overlap at the start, in the output directory.
#pragma once

#include "input/config.hpp"
#include "model/start_overlap.hpp"

#include <mpi.h>

namespace pliant {

/// Writes `overlap.vtu`: the facets, with the numbers `body` and `other` of the bodies in the order of the input and
/// their `depth` [m]. Returns the errors with the path of the file, or with the reason why there is none. Collective.
InputError with_overlap_file(MPI_Comm comm, const Config& config, const OverlapError& error);

/// Removes that of an earlier run. Collective.
void remove_overlap_file(MPI_Comm comm, const Config& config);

}  // namespace pliant
