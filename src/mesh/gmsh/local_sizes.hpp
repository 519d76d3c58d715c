/// Element sizes at physical groups.
#pragma once

#include "mesh/mesh.hpp"

#include <optional>
#include <span>

namespace pliant {

/// Makes the sizes those of gmsh's current model, at most `size` elsewhere, or what gmsh would choose without one:
/// fields Distance and Threshold for each, and Min of all. Throws MeshDefect if the model has no such group.
void impose_local_sizes(std::span<const LocalSize> sizes, const std::optional<double>& size);

}  // namespace pliant
