/// Runs that an earlier sweep has left in a directory.
#pragma once

#include <filesystem>
#include <vector>

namespace pliant {

/// Throws InputError if a directory has runs of a sweep other than these, which would lie among them. `runs`: the
/// directories of the sweep that is to begin, which may exist. Not collective.
void refuse_other_runs(const std::filesystem::path& directory, const std::vector<std::filesystem::path>& runs);

}  // namespace pliant
