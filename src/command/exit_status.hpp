/// The message and the exit code of a program of Pliant that fails.
#pragma once

#include "base/error.hpp"

#include <functional>

namespace pliant {

/// What `program` returns, or the exit code of the failure that it throws, which is reported on stderr once. A failure
/// that the ranks have not agreed on ends them all. To be called within a Session. Collective.
int exit_status(const std::function<ExitCode()>& program);

}  // namespace pliant
