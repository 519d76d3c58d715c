/// The keys of an entry of `constraints`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<ConstraintConfig> constraint_keys();

}  // namespace pliant
