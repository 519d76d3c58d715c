#include "model/curved_facets.hpp"

#include "collision/candidates.hpp"
#include "collision/overlaps.hpp"

#include <algorithm>

namespace pliant {

bool is_too_curved(const NodeLayout& layout, const TouchingSurfaces& touching, std::size_t num_bodies) {
  const BodySurfaces of_means(layout, touching.facets, touching.sides, FacetVertices::mean);
  const BodySurfaces of_nodes(layout, touching.facets, touching.sides, FacetVertices::nodes);
  const auto x = of_means.surface().rest_positions(), X = of_nodes.surface().rest_positions();
  double farthest = 0.0;
  for (std::size_t vertex = 0; vertex < x.size(); ++vertex) farthest = std::max(farthest, norm(x[vertex] - X[vertex]));
  if (farthest < 1e-9 * of_nodes.surface().longest_edge()) return false;  // straight edges, up to rounding
  // Where it is farther apart than this, the distance of the one is more than half of the other's.
  const double distance = 4.0 * farthest;
  const auto n = static_cast<int>(num_bodies);
  const auto apart = least_distances(of_means.surface(), x, n, distance),
             apart_of_nodes = least_distances(of_nodes.surface(), X, n, distance);
  for (std::size_t pair = 0; pair < apart.size(); ++pair) {
    if (apart[pair] < 0.5 * apart_of_nodes[pair]) return true;
  }
  return !find_overlaps(of_means.surface(), x, touching.sets).empty() &&
         find_overlaps(of_nodes.surface(), X, touching.sets).empty();
}

}  // namespace pliant
