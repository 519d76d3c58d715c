/// The keys of `time`: methods by name, the user's own, PETSc's; steps, their adaptation, events.
#pragma once

#include "input/schema.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Every name that `method` takes: the table's, the equilibria's, PETSc's with their prefix.
std::vector<std::string> time_methods();

Section<TimeConfig> time_keys();

}  // namespace pliant
