/// The keys of an entry of `loads`.
#pragma once

#include "app/schema.hpp"

namespace pliant {

Section<LoadConfig> load_keys();

}  // namespace pliant
