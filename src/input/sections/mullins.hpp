/// The keys of `mullins`.
#pragma once

#include "input/config.hpp"
#include "input/schema.hpp"

namespace pliant {

Section<MullinsConfig> mullins_keys();

}  // namespace pliant
