/// The keys of a body's `viscosity`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

/// One mechanism, or a list of them that act side by side.
Format<std::vector<ViscosityConfig>> viscosity_format();

}  // namespace pliant
