/// The keys of a body's `viscosity`.
#pragma once

#include "app/schema.hpp"

namespace pliant {

Section<ViscosityConfig> viscosity_keys();

}  // namespace pliant
