/// What fades the potential of two edges out as they become parallel, where their distance has no second derivative.
#pragma once

#include "collision/expansion.hpp"

#include <span>

namespace pliant {

/// With u and v the two edges and c = |u x v|^2,
///
///     m = g(c / c_0),   g(y) = 10 y^3 - 15 y^4 + 6 y^5   (y < 1),   1   (y >= 1)
///
/// which has two continuous derivatives, as the potential of a barrier has, where the usual 2 y - y^2 (Li et al. 2020,
/// Incremental Potential Contact, equation 24) has one. The third power lets m grow as the sixth of the angle, which
/// outweighs the second derivatives of the distance, of the order of its inverse square.
///
/// c_0 [m^4] is mollifier_threshold of the edges at rest. `x`: the edge u, then the edge v [m].
Expansion<4> edge_edge_mollifier(std::span<const Vector3<double>, 4> x, double threshold);

/// m alone.
double edge_edge_mollifier_value(std::span<const Vector3<double>, 4> x, double threshold);

/// c_0 = 10^-3 |U|^2 |V|^2 of the edges at rest [m^4]: edges that keep their lengths are faded out below 1.8 degrees.
double mollifier_threshold(std::span<const Vector3<double>, 4> X);

}  // namespace pliant
