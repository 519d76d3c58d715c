/// The keys of an entry of `loads`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<LoadConfig> load_keys();

}  // namespace pliant
