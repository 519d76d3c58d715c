#include "base/child_process.hpp"

#include "base/confinement.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <string_view>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <vector>

namespace pliant {
namespace {

constexpr int left_by_exit = 77;

void write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno != EINTR) return;  // the reader sees an incomplete answer
    if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

using Clock = std::chrono::steady_clock;

/// Waits for bytes, the end of the file, or the deadline; false at the deadline.
bool wait_for_bytes(int file, const std::optional<Clock::time_point>& deadline) {
  while (deadline) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(*deadline - Clock::now()).count();
    if (left <= 0) return false;
    constexpr std::chrono::milliseconds::rep longest = 1'000'000;
    pollfd waiting{file, POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(std::min(left, longest))) > 0) return true;
  }
  return true;
}

/// Reads to the end of the file; returns nothing if the deadline comes first.
std::optional<std::string> read_all(int file, const std::optional<Clock::time_point>& deadline) {
  std::string bytes;
  std::vector<char> buffer(1 << 20);
  for (;;) {
    if (!wait_for_bytes(file, deadline)) return std::nullopt;
    const ssize_t size = read(file, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return bytes;
    bytes.append(buffer.data(), static_cast<std::size_t>(size));
  }
}

[[noreturn]] void be_the_child(int answer, ChildRights rights, const std::function<std::string()>& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal, SIG_DFL);
  // Runs before the handlers of MPI and others, which must not act twice.
  std::atexit([] { _exit(left_by_exit); });
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  if (rights == ChildRights::reading) renounce_commands_and_files();
  write_all(answer, work());
  _exit(0);
}

}  // namespace

ChildEnd in_child(const std::function<std::string()>& work, const ChildLimits& limits) {
  std::optional<Clock::time_point> deadline;
  if (limits.time) deadline = Clock::now() + *limits.time;
  std::array<int, 2> channel{};
  if (pipe(channel.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot start another process");
  }
  std::fflush(nullptr);  // otherwise the child would write the buffered text a second time
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "cannot start another process");
  if (child == 0) {
    close(channel[0]);
    be_the_child(channel[1], limits.rights, work);
  }
  close(channel[1]);
  std::optional<std::string> answer = read_all(channel[0], deadline);
  close(channel[0]);
  if (!answer) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!answer) return {std::nullopt, false, true, "it ran out of time"};
  if (WIFSIGNALED(status)) return {std::nullopt, false, false, strsignal(WTERMSIG(status))};
  const int code = WEXITSTATUS(status);
  if (code != 0) return {std::nullopt, code == left_by_exit, false, "exit code " + std::to_string(code)};
  return {std::move(answer), false, false, {}};
}

}  // namespace pliant
