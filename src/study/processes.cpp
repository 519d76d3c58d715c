#include "study/processes.hpp"

#include "run/signals.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <map>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;

volatile std::sig_atomic_t received = 0;

void note_signal(int number) {
  received = number;
}

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (const std::string& text : texts) result.push_back(const_cast<char*>(text.c_str()));
  result.push_back(nullptr);
  return result;
}

/// The process id, or 0 if it could not be started.
pid_t start(const Program& program, const Environment& environment) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  if (!program.log.empty()) {
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, program.log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
    posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  }
  pid_t pid = 0;
  const int failed = posix_spawnp(&pid, program.arguments.front().c_str(), &files, nullptr,
                                  pointers(program.arguments).data(), pointers(environment).data());
  posix_spawn_file_actions_destroy(&files);
  return failed == 0 ? pid : 0;
}

struct Running {
  std::size_t index;
  Clock::time_point since;
};

}  // namespace

Environment current_environment() {
  Environment result;
  for (char** variable = environ; *variable != nullptr; ++variable) result.emplace_back(*variable);
  return result;
}

std::vector<Ended> run_all(const std::vector<Program>& programs, const Environment& environment, int at_once,
                           const std::function<void(std::size_t, const Ended&)>& on_end) {
  received = 0;
  SignalHandlers handlers;
  for (const int number : stop_signals) handlers.set(number, note_signal);
  handlers.set(SIGPIPE, SIG_IGN);  // the runs continue without a reader
  std::vector<Ended> ended(programs.size());
  std::map<pid_t, Running> running;
  int handed_on = 0;
  const auto end = [&](std::size_t index, const Ended& how) {
    ended[index] = how;
    on_end(index, how);
  };
  std::size_t next = 0;
  while (next < programs.size() || !running.empty()) {
    const int signal = received;
    if (signal != 0 && signal != handed_on) {
      for (const auto& [pid, what] : running) kill(pid, signal);
      handed_on = signal;
    }
    if (next < programs.size() && (signal != 0 || std::ssize(running) < at_once)) {
      const std::size_t index = next++;
      const pid_t pid = signal != 0 ? 0 : start(programs[index], environment);
      if (pid != 0) {
        running[pid] = {index, Clock::now()};
      } else {
        end(index, {signal != 0 ? 128 + signal : 127, 0.0});
      }
      continue;
    }
    // Polled instead of waited for: a signal may arrive just before the wait.
    int status = 0;
    const pid_t pid = waitpid(-1, &status, WNOHANG);
    const auto found = running.find(pid);
    if (found == running.end()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    const Running what = found->second;
    running.erase(found);
    int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (code != 0 && handed_on != 0) code = 128 + handed_on;  // mpirun gives 1 then
    end(what.index, {code, std::chrono::duration<double>(Clock::now() - what.since).count()});
  }
  return ended;
}

int usable_processors() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
}

}  // namespace pliant
