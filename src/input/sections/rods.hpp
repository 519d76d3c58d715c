/// The keys of `rods[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<RodConfig> rod_keys();

}  // namespace pliant
