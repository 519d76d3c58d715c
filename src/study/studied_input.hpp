/// The inputs of a convergence study.
#pragma once

#include "study/converge.hpp"

#include <string>
#include <vector>

namespace pliant {

/// The input once for each method. Throws InputError if it cannot be studied. Collective.
std::vector<Config> read_studied_inputs(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                                        const StudyOptions& options);

}  // namespace pliant
