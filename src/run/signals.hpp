/// Interruption by the user or the batch system.
#pragma once

#include <array>
#include <csignal>
#include <utility>
#include <vector>

#include <mpi.h>

namespace pliant {

/// Signals that ask a run to stop: Ctrl-C, the batch system, a closed terminal, a limit of processor time; and SIGUSR2,
/// which mpirun forwards without killing its ranks a second later.
inline constexpr std::array stop_signals{SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR2};

/// Replaces signal handlers during its lifetime. At most one object per process, since signals are per process.
class SignalHandlers {
 public:
  SignalHandlers() = default;
  ~SignalHandlers();
  SignalHandlers(const SignalHandlers&) = delete;
  SignalHandlers& operator=(const SignalHandlers&) = delete;

  /// Leaves SIGHUP ignored if nohup has made the process ignore it.
  void set(int number, void (*handler)(int));

 private:
  std::vector<std::pair<int, void (*)(int)>> before_;
};

/// What a run shall do between two steps; each request includes those before it.
enum class Request { none, checkpoint, stop };

/// During its lifetime, `stop_signals` and SIGUSR1 (checkpoint) are only recorded, and readers of a pipe may disappear:
/// a checkpoint is written after Ctrl-C even if `tee` ended at once. At most one object per process.
class InterruptGuard {
 public:
  InterruptGuard();

  /// The request of a signal to any rank, or of any rank itself by `mine`. Collective.
  Request request(MPI_Comm comm, Request mine) const;

 private:
  SignalHandlers handlers_;
};

}  // namespace pliant
