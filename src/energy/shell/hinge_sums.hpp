/// What the terms of the bending of layers have in common: slopes of the angles, and sums over triangles and edges.
#pragma once

#include "energy/shell/bending_stencils.hpp"
#include "fem/block_matrix.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace pliant {

/// A number for each node a, b, c, o of a hinge and each direction: xyz of a, then of b, ...
using OfHingeNodes = std::array<double, 12>;

/// The derivatives of the angles of all hinges by their nodes, at displacements q [1/m]. Not collective.
std::vector<OfHingeNodes> slopes_of_angles(const BendingStencils& seen, std::span<const double> q);
/// The product of the second derivative of an angle with displacements d of the local nodes [1/m].
OfHingeNodes bend_along(const BendingHinge& hinge, std::span<const double> q, std::span<const double> d);
/// The sum over the nodes of a hinge.
double sum_over_nodes(const BendingHinge& hinge, const OfHingeNodes& slopes, std::span<const double> d);

/// r += sum of moments * slopes, on rows of owned nodes.
void add_moments(const BendingStencils& seen, std::span<const double> moments, std::span<const OfHingeNodes> slopes,
                 PetscInt num_owned_nodes, std::span<double> r);
/// K += sum over hinges g, h of a stencil of left_g M_gh (x) right_h, on rows of owned nodes. `M`: by rows of
/// BendingStencil::most_hinges.
void add_products(const BendingStencil& stencil, std::span<const double> M, std::span<const OfHingeNodes> left,
                  std::span<const OfHingeNodes> right, PetscInt num_owned_nodes, const BlockWriter& K);
/// K += moment times the second derivative of the angle, on rows of owned nodes.
void add_bend(const BendingHinge& hinge, double moment, std::span<const double> q, PetscInt num_owned_nodes,
              const BlockWriter& K);

}  // namespace pliant
