/// What `pliant check` says of bodies, and of what connects them.
#pragma once

#include "model/model.hpp"

#include <string>
#include <vector>

namespace pliant {

/// A heading and a line for each body: its cells and its material, or mass and centre of a rigid one. Collective.
std::vector<std::string> body_table(const Config& config, const Model& model);

/// Rods with their stiffness, likewise; nothing where there are none.
std::vector<std::string> rod_table(const Config& config, const Model& model);

/// Shells with their facets and materials, likewise.
std::vector<std::string> shell_table(const Config& config, const Model& model);

/// Rigid parts that the input asks for, with their centers, likewise.
std::vector<std::string> rigid_part_table(const Config& config, const Model& model);

/// Joints, springs and tendons, a heading and a line for each; nothing where there are none. Collective.
std::vector<std::string> mechanism_table(const Config& config, const Model& model);

}  // namespace pliant
