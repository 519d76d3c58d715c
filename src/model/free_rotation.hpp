/// Rotations about a line that constraints leave to bodies without inertia.
#pragma once

#include "base/error.hpp"
#include "fem/components.hpp"
#include "input/config.hpp"

#include <optional>
#include <span>

namespace pliant {

/// A note if prescribed displacements hold a component against every translation, but leave it free to rotate about a
/// line or a point, and nothing else may hold it: without inertia the stiffness is singular there. `is_given`: per
/// local entry, whether its displacement is prescribed; nothing else is constrained. Collective.
std::optional<Diagnostic> note_about_free_rotation(const Config& config, const NodeLayout& layout,
                                                   const Components& components, std::span<const char> is_given);

}  // namespace pliant
