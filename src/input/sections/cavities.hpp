/// The keys of an entry of `cavities`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<CavityConfig> cavity_keys();

}  // namespace pliant
