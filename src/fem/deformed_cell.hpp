/// The volume change and quality of a deformed cell.
#pragma once

#include "fem/layout.hpp"

#include <array>
#include <span>

namespace pliant {

struct DeformedCell {
  double volume_ratio = 1.0;       ///< the least J = det(dx/dxi) / det(dX/dxi) of corners and inner points
  double quality = 1.0;            ///< mean ratio of the deformed corners: 1 regular, 0 flat or inverted
  double reference_quality = 1.0;  ///< mean ratio of the undeformed corners
  std::array<double, 3> X{};       ///< mean of its corners in the reference configuration [m]
};

/// A local cell at the displacements u of the local nodes [m]. Not collective.
DeformedCell deformed_cell(const NodeLayout& layout, PetscInt cell, std::span<const double> u);

}  // namespace pliant
