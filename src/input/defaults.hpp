/// Defaults that follow from other keys.
#pragma once

#include "input/config.hpp"
#include "input/tree.hpp"

namespace pliant {

/// Puts these defaults into a configuration that was read from `root`, and resolves files against the directory of
/// `config.file`.
void complete_defaults(Config& config, const InputNode& root);

}  // namespace pliant
