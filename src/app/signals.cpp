#include "app/signals.hpp"

#include "petsc/collective.hpp"

#include <csignal>

namespace pliant {
namespace {

volatile std::sig_atomic_t received = 0;  // a signal handler can reach nothing else

void note(int) {
  received = 1;
}

}  // namespace

InterruptGuard::InterruptGuard() {
  received = 0;
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::interrupted(MPI_Comm comm) const {
  return any(comm, received != 0);
}

}  // namespace pliant
