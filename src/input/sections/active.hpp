/// The keys of `bodies[].active`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<ActiveConfig> active_keys();

}  // namespace pliant
