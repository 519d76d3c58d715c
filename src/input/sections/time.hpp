/// The keys of `time`: methods by name, the user's own, PETSc's; steps, their adaptation, events.
#pragma once

#include "input/schema.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// Methods that are no integrators but sequences of equilibria.
inline constexpr std::string_view quasistatic_method = "quasistatic";
inline constexpr std::string_view static_method = "static";

/// Before the name of an integrator of PETSc: petsc:alpha2.
inline constexpr std::string_view petsc_prefix = "petsc:";

/// Every name that `method` takes: the table's, the equilibria's, PETSc's with their prefix.
std::vector<std::string> time_methods();

Section<TimeConfig> time_keys();

}  // namespace pliant
