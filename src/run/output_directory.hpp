/// The directory of a run's files.
#pragma once

#include "base/file.hpp"
#include "input/config.hpp"
#include "run/checkpoints.hpp"

#include <optional>

#include <mpi.h>

namespace pliant {

/// Holds the output directory of the input: while it lives, no other run writes there.
class OutputDirectory {
 public:
  /// Creates and locks it, and removes the summary of an earlier run. Throws FileError on every rank. Collective.
  OutputDirectory(MPI_Comm comm, const Config& config);
  /// Removes what an earlier run has left that this one may not write: checkpoints, post-mortem, overlaps. Collective.
  void start_anew(Checkpoints& checkpoints);

 private:
  MPI_Comm comm_;
  const Config& config_;
  std::optional<DirectoryLock> lock_;  // held by rank 0
};

}  // namespace pliant
