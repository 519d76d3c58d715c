/// Interruption by the user or the batch system.
#pragma once

#include <mpi.h>

namespace pliant {

/// What a run is to do between two steps; the later ones include the earlier ones.
enum class Request { none, checkpoint, stop };

/// While it lives, SIGINT, SIGTERM (stop) and SIGUSR1 (checkpoint) only leave a note. One per process.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// What a signal to any rank asks for, or any rank itself with `mine`. Collective.
  Request request(MPI_Comm comm, Request mine) const;
};

}  // namespace pliant
