/// The displacement at the start at the nodes.
#pragma once

#include "fem/layout.hpp"
#include "input/config.hpp"

#include <vector>

namespace pliant {

/// At all local nodes [m]. Not collective.
std::vector<double> initial_displacement(const VectorExpression& formula, const NodeLayout& layout);

}  // namespace pliant
