/// The keys of an entry of `constraints`.
#pragma once

#include "app/schema.hpp"

namespace pliant {

Section<ConstraintConfig> constraint_keys();

}  // namespace pliant
