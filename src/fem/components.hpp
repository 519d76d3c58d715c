/// Components of the mesh: parts that share no node, separate bodies as far as the material is concerned.
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
      outer_sides;             ///< if there are several: per owned cell, bit i marks the side opposite to corner i
  std::vector<char> is_outer;  ///< if there are several: per local node, whether it is on one of these sides
  std::vector<char>
      is_left_out;  ///< per local cell: one that is not of the mesh and overlaps with nothing; empty: none
  std::vector<int>
      of_node;  ///< component 0 .. count - 1 of each local node, ghosts included; the same numbers on every rank
};

/// Components are numbered by their lowest global node. Collective.
Components connected_components(const NodeLayout& layout);

/// The owned nodes of each component in which no owned node of any rank `is_held`. Lists hold this rank's nodes only
/// and may be empty. Collective.
std::vector<std::vector<PetscInt>> free_components(const NodeLayout& layout,
                                                   const std::function<bool(PetscInt node)>& is_held);

/// Merges all components that contain one of these nodes; each rank gives its own. Collective.
void join(Components& components, const NodeLayout& layout, std::span<const PetscInt> nodes);

/// A node that lies inside another component.
struct Overlap {
  double depth = 0.0;          ///< a lower bound of its depth below the surface [m]
  std::array<double, 3> at{};  ///< the node's current position [m]
  int of = 0, in = 0;          ///< the node's component, and the one that contains it
};

/// The deepest overlap at the displacement u of local nodes; nothing if no component penetrates another by more than a
/// twentieth of a cell. Examines at most `most_nodes` of each rank's nodes where the components' boxes meet, evenly
/// chosen. Cells count as straight, less what their sides may be bent. `are_kept_apart`: of each two components, by
/// rows, whether their overlaps do not count; empty: all count. Collective.
std::optional<Overlap> deepest_overlap(const NodeLayout& layout, const Components& components,
                                       std::span<const double> u, std::size_t most_nodes = 20000,
                                       std::span<const char> are_kept_apart = {});

}  // namespace pliant
