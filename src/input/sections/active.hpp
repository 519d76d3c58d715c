/// The keys of `bodies[].active` and `bodies[].expansion`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<ActiveConfig> active_keys();
Section<ExpansionConfig> expansion_keys();

}  // namespace pliant
