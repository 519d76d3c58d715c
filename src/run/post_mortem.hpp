/// The post-mortem of a run that cannot continue: the directory post-mortem next to its results.
#pragma once

#include "run/failure_report.hpp"
#include "run/simulation.hpp"

#include <string>

namespace pliant {

/// Writes report.yaml, and state.h5 with state.xdmf: a frame of the last good state, and one of the last iterate
/// (displacement, residual and last Newton step per node; smallest J and quality per cell). Returns where to look, as a
/// clause without a full stop. Throws FileError on every rank. Collective.
std::string write_post_mortem(const Config& config, const Model& model, const StepRecord& last_good,
                              const Failure& failure);

/// Removes the post-mortem of an earlier run. Collective.
void remove_post_mortem(MPI_Comm comm, const Config& config);

}  // namespace pliant
