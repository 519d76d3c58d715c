/// What kind of problem an input poses.
#pragma once

#include "input/config.hpp"

namespace pliant {

enum class Analysis { dynamic, quasistatic, static_equilibrium };

/// What `time.method` asks for.
Analysis analysis_of(const Config& config);

/// The method that advances time; nullptr for static diagnostics and PETSc's integrators.
const Method* integrator_of(const Config& config);

}  // namespace pliant
