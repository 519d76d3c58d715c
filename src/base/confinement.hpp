/// A process that gives up what it does not need.
#pragma once

namespace pliant {

/// From now on this process, and those it starts, can run no programs, change no files and open no sockets: the system
/// answers such calls with "permission denied". It cannot be taken back. Returns false, and changes nothing, where the
/// system does not offer it. For a child process that works on a file nobody has vouched for (seccomp(2)).
bool renounce_commands_and_files() noexcept;

}  // namespace pliant
