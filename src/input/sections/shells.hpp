/// The keys of `shells[]`.
#pragma once

#include "input/schema.hpp"

namespace pliant {

Section<ShellConfig> shell_keys();

}  // namespace pliant
