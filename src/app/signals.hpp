/// Interruption by the user or the batch system.
#pragma once

#include <mpi.h>

namespace pliant {

/// While it lives, SIGINT and SIGTERM only leave a note, so that the run ends between two steps. One per process.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Whether a signal has reached any rank. Collective.
  bool interrupted(MPI_Comm comm) const;
};

}  // namespace pliant
