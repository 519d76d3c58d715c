/// Interruption by the user or the batch system.
#pragma once

#include <array>
#include <csignal>
#include <utility>
#include <vector>

#include <mpi.h>

namespace pliant {

/// What asks a run to stop: Ctrl-C, the batch system, a terminal that is gone, a limit of processor time; and SIGUSR2,
/// which mpirun passes on without ending its ranks a second later.
inline constexpr std::array stop_signals{SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR2};

/// While it lives, signals do something else. One of its kind per process, as signals are.
class SignalHandlers {
 public:
  SignalHandlers() = default;
  ~SignalHandlers();
  SignalHandlers(const SignalHandlers&) = delete;
  SignalHandlers& operator=(const SignalHandlers&) = delete;

  /// Whom nohup has made deaf to SIGHUP stays so.
  void set(int number, void (*handler)(int));

 private:
  std::vector<std::pair<int, void (*)(int)>> before_;
};

/// What a run is to do between two steps; the later ones include the earlier ones.
enum class Request { none, checkpoint, stop };

/// While it lives, `stop_signals` and SIGUSR1 (checkpoint) only leave a note, and who read along may go: a checkpoint
/// is written after Ctrl-C even if `tee` ended at once. One per process.
class InterruptGuard {
 public:
  InterruptGuard();

  /// What a signal to any rank asks for, or any rank itself with `mine`. Collective.
  Request request(MPI_Comm comm, Request mine) const;

 private:
  SignalHandlers handlers_;
};

}  // namespace pliant
