/// What a program of Pliant tells and returns when it fails.
#pragma once

#include "base/error.hpp"

#include <functional>

namespace pliant {

/// What `program` returns, or the code of the failure it throws, which is told on stderr once. A failure that the ranks
/// have not agreed on ends them all. To be called within a Session. Collective.
int exit_status(const std::function<ExitCode()>& program);

}  // namespace pliant
