#include "run/signals.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <ranges>

namespace pliant {
namespace {

// A signal handler can reach nothing else.
volatile std::sig_atomic_t stop_received = 0, checkpoint_received = 0;

void note_stop(int) {
  stop_received = 1;
}

void note_checkpoint(int) {
  checkpoint_received = 1;
}

}  // namespace

void SignalHandlers::set(int number, void (*handler)(int)) {
  const auto before = std::signal(number, handler);
  before_.emplace_back(number, before);
  if (number == SIGHUP && before == SIG_IGN) std::signal(number, SIG_IGN);
}

SignalHandlers::~SignalHandlers() {
  for (const auto& [number, handler] : std::views::reverse(before_)) std::signal(number, handler);
}

InterruptGuard::InterruptGuard() {
  stop_received = 0;
  checkpoint_received = 0;
  for (const int number : stop_signals) handlers_.set(number, note_stop);
  handlers_.set(SIGUSR1, note_checkpoint);
  handlers_.set(SIGPIPE, SIG_IGN);
}

Request InterruptGuard::request(MPI_Comm comm, Request mine) const {
  if (checkpoint_received != 0) {
    checkpoint_received = 0;
    mine = std::max(mine, Request::checkpoint);
  }
  if (stop_received != 0) mine = Request::stop;
  return static_cast<Request>(static_cast<int>(maximum(comm, static_cast<int>(mine))));
}

}  // namespace pliant
