/// What a body may have in addition to its laws of elasticity and viscosity.
#pragma once

#include "base/error.hpp"
#include "base/expression.hpp"
#include "material/mullins.hpp"

namespace pliant {

/// Expansion by heat or swelling.
struct ExpansionConfig {
  Expression stretch;  ///< in all directions, free of stress; a function of x, y, z, t
  Location where;
};

/// Softening by the largest strain of the past.
struct MullinsConfig {
  Mullins law;
  Location where;
};

}  // namespace pliant
