/// The keys of `contact`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<ContactConfig> contact_keys();

}  // namespace pliant
