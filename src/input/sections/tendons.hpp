/// The keys of `tendons[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<TendonConfig> tendon_keys();

}  // namespace pliant
