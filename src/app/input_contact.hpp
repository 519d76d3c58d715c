/// The keys of `contact`.
#pragma once

#include "app/schema.hpp"

namespace pliant {

Section<ContactConfig> contact_keys();

}  // namespace pliant
