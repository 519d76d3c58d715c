/// What is near one another on the surfaces of bodies, for reports.
#pragma once

#include "energy/contact/touching_bodies.hpp"
#include "energy/pairs/observed_pairs.hpp"
#include "energy/pairs/pair_assembly.hpp"

#include <span>
#include <utility>
#include <vector>

namespace pliant {

/// A search for what is nearer than a distance, apart from that of the solver. The layout and the bodies outlive it.
struct ContactObservation {
  const NodeLayout& layout;
  double distance;  // [m]
  ObservedPairs coupling;
  std::vector<char> nothing_prescribed;
  PairAssembly pairs;

  ContactObservation(const NodeLayout& of, const TouchingBodies& bodies, double within)
      : layout(of),
        distance(within),
        coupling(bodies, within),
        nothing_prescribed(3 * static_cast<std::size_t>(layout.num_local_nodes), 0),
        pairs(layout, {&coupling}, nothing_prescribed) {}

  /// What is near at q, and q with the nodes that it needs. Collective.
  std::pair<const NearPatches&, std::vector<double>> at(std::span<const double> q) {
    (void)pairs.follow({q});
    std::vector<double> all;
    pairs.extend(q, all);
    return {pairs.near(0), std::move(all)};
  }
};

}  // namespace pliant
