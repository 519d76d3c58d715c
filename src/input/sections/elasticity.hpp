/// The keys of `bodies[].elasticity`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

/// The model and the constants of all laws; what they determine together is checked too.
Format<ElasticityConfig> elasticity_format();

}  // namespace pliant
