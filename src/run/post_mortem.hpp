/// What a run leaves that cannot go on: the directory post-mortem beside its results.
#pragma once

#include "run/failure_report.hpp"
#include "run/simulation.hpp"

#include <string>

namespace pliant {

/// Writes report.yaml, and state.h5 with state.xdmf: a frame of the last good state, and one of where the iteration
/// ended (displacement, residual, Newton's last step per node; least J and quality per cell). Returns what to look at,
/// in a sentence without its end. FileError on every rank. Collective.
std::string write_post_mortem(const Config& config, const Model& model, const StepRecord& last_good,
                              const Failure& failure);

/// Removes that of an earlier run. Collective.
void remove_post_mortem(MPI_Comm comm, const Config& config);

}  // namespace pliant
