/// The keys of `output`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<OutputConfig> output_keys();

}  // namespace pliant
