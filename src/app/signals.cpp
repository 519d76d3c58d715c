#include "app/signals.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <csignal>

namespace pliant {
namespace {

// A signal handler can reach nothing else.
volatile std::sig_atomic_t stop_received = 0, checkpoint_received = 0;

void note_request(int number) {
  if (number == SIGUSR1) {
    checkpoint_received = 1;
  } else {
    stop_received = 1;
  }
}

}  // namespace

InterruptGuard::InterruptGuard() {
  stop_received = 0;
  checkpoint_received = 0;
  for (const int number : {SIGINT, SIGTERM, SIGUSR1}) std::signal(number, note_request);
}

InterruptGuard::~InterruptGuard() {
  for (const int number : {SIGINT, SIGTERM, SIGUSR1}) std::signal(number, SIG_DFL);
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
