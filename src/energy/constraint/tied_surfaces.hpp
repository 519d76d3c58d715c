/// Surfaces of meshes that do not match, tied to one another (mesh tying, mortar method).
///
/// u_a = u_b holds on the dependent surface weakly, in as many averages as a has nodes. Those of the dual mortar method
/// (Wohlmuth 2000, A mortar finite element method using dual spaces for the Lagrange multiplier) give each node i of a
/// a row of its own: with the projections P_e u_b onto the facets e around it (facet_projection.hpp),
///
///   u_i = sum_e A_e (P_e u_b)_i / sum_e A_e.
///
/// Every linear motion of b gives a the same. The averages contain the constant ones, int (u_a - u_b) dA = 0 over a:
/// sum_i s_i (u_i - (u_b)_i) = 0 with the integrals s_i of the shape functions, which are A_e / 3 per facet at each
/// node of P1 and each mid-edge node of P2, and 0 at corners of P2. A constant stress is therefore in equilibrium
/// (patch test). Interpolation at the nodes of a (collocation) lacks this, and misses the stress in a cube of 3
/// to 12 elements along an edge by 60 to 6 %.
#pragma once

#include "energy/constraint/facet_projection.hpp"
#include "energy/constraint/linear_constraint.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace pliant {

/// A node of the dependent surface that is tied: u_node = sum of the weights' displacements.
struct TiedNode {
  PetscInt node = 0;                 ///< global
  double area = 0.0;                 ///< sum_e A_e, the scale of its row [m^2]
  bool is_shared = false;            ///< with the independent surface: the mesh itself ties it
  bool has_share = false;            ///< of tractions: s_i > 0
  std::vector<NodeWeight> weights;   ///< by ascending node
  std::vector<PetscInt> neighbours;  ///< the other nodes of its facets, ascending, global
};

/// The same on every rank.
struct SurfaceTie {
  std::size_t source = 0;                                           ///< index of the constraint in the input
  std::vector<TiedNode> nodes;                                      ///< by ascending node, shared ones included
  double tolerance = 0.0;                                           ///< [m]
  std::size_t num_shared = 0;                                       ///< nodes that both surfaces have
  std::size_t num_free = 0;                                         ///< nodes that are farther than the tolerance
  double largest_gap = 0.0;                                         ///< of a tied node [m]
  double least_distance = std::numeric_limits<double>::infinity();  ///< of a free node [m]
  Vector3<double> nearest_free{};                                   ///< where it is [m]

  std::size_t num_tied() const { return nodes.size() - num_shared; }
};

/// The part of the mean edge of the surface with longer edges that is the tolerance if none is given.
inline constexpr double default_tie_tolerance = 0.1;

/// Facets with the cells behind them: `cells` has the local cell of each facet.
struct FacetsWithCells {
  const FacetList& facets;
  const std::vector<PetscInt>& cells;
};

/// Ties the nodes of `dependent` to `independent`, whose cells are needed where facets are owned. Neither is empty.
/// `tolerance` [m]: the largest distance. Collective.
SurfaceTie tie_surfaces(const NodeLayout& layout, const FacetList& dependent, const FacetsWithCells& independent,
                        std::optional<double> tolerance, std::size_t source);

/// The nodes that the tie couples, ascending.
std::vector<PetscInt> nodes_of(const SurfaceTie& tie);

}  // namespace pliant
