/// Confines a process: it gives up the rights that it does not need.
#pragma once

namespace pliant {

/// From now on this process and its children cannot run programs, change files or open sockets: the system answers such
/// calls with "permission denied". This cannot be undone. Returns false, and changes nothing, where the system does not
/// support it. Meant for a child process that reads an untrusted file (seccomp(2)).
bool renounce_commands_and_files() noexcept;

}  // namespace pliant
