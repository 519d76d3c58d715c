/// Parts of the mesh that share no node: bodies of their own as far as the material goes.
#pragma once

#include "fem/layout.hpp"

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

struct Components {
  int count = 1;
  std::vector<unsigned char>
      outer_sides;           ///< if there are several: of each owned cell, bit i of the side opposite to i
  std::vector<int> of_node;  ///< 0 .. count - 1 of each local node, ghosts included; the same numbers on every rank
};

/// The numbers ascend with the lowest global node. Collective.
Components connected_components(const NodeLayout& layout);

/// The owned nodes of each component of which no owned node `is_held` on any rank; of those of other ranks none, so
/// that a list may be empty. Collective.
std::vector<std::vector<PetscInt>> free_components(const NodeLayout& layout,
                                                   const std::function<bool(PetscInt node)>& is_held);

/// Makes one of all components that have one of these nodes, which are each rank's own. Collective.
void join(Components& components, const NodeLayout& layout, std::span<const PetscInt> nodes);

/// A node that lies inside of another component.
struct Overlap {
  double depth = 0.0;          ///< below the surface [m], or less
  std::array<double, 3> at{};  ///< the node's current position [m]
  int of = 0, in = 0;          ///< the node's component, and the one that it is in
};

/// The deepest overlap at the displacement u of local nodes; nothing if no component penetrates another by more than a
/// twentieth of a cell. Examines at most `most_nodes` of each rank's nodes where the components' boxes meet, evenly
/// chosen. Edges count as straight. Collective.
std::optional<Overlap> deepest_overlap(const NodeLayout& layout, const Components& components,
                                       std::span<const double> u, std::size_t most_nodes = 20000);

}  // namespace pliant
