/// The kind of problem that an input poses.
#pragma once

#include "input/config.hpp"

#include <string>

namespace pliant {

enum class Analysis { dynamic, quasistatic, static_equilibrium };

/// What `time.method` asks for; dynamic if the input is wrong.
Analysis analysis_of(const TimeConfig& time);
Analysis analysis_of(const Config& config);

/// The method's name as users type it; empty if the input is wrong.
std::string method_name(const MethodConfig& method);

/// The method that advances time; nullptr for static problems and PETSc's integrators.
const Method* integrator_of(const Config& config);

}  // namespace pliant
