/// The keys of `bodies[].active`.
#pragma once

#include "app/schema.hpp"

namespace pliant {

Section<ActiveConfig> active_keys();

}  // namespace pliant
