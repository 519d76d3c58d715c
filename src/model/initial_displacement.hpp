/// Displacements and velocities at the start at the nodes.
#pragma once

#include "fem/layout.hpp"
#include "input/config.hpp"

#include <vector>

namespace pliant {

/// At all local nodes [m]. Not collective.
std::vector<double> initial_displacement(const VectorExpression& formula, const NodeLayout& layout);

/// The displacements [m] and velocities [m/s] that the input gives, whatever constraints make of them: `initial`, and
/// the velocities of rigid bodies. `config`: with all rigid bodies. Not collective.
void put_initial_state(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell, Vec q,
                       Vec v);

}  // namespace pliant
