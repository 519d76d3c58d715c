/// Integrals over cells and facets of functions of the position, from the numbers of the layout: not for hot loops.
#pragma once

#include "base/tensor.hpp"
#include "fem/layout.hpp"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace pliant {

/// A point of a cell or of a facet.
struct IntegrationPoint {
  double weight = 0.0;            ///< its reference volume [m^3] or area [m^2]
  std::span<const double> shape;  ///< N_a, of as many nodes as the cell or the facet has
  std::array<double, 3> xi{};     ///< on the reference tetrahedron; not of a facet
};

/// Visits the points of a local cell's rule, which integrates squares of functions of the element exactly on straight
/// cells.
void for_each_point_of_cell(const NodeLayout& layout, PetscInt cell,
                            const std::function<void(const IntegrationPoint&)>& visit);
/// Likewise for a facet, given by its local nodes: corners, then mid-edge nodes 01 12 02.
void for_each_point_of_facet(const NodeLayout& layout, std::span<const PetscInt> nodes,
                             const std::function<void(const IntegrationPoint&)>& visit);

/// The reference position of a point of a local cell [m], and grad u there; xi: on the reference tetrahedron, u: of
/// the local nodes, three numbers each.
std::array<double, 3> position_in_cell(const NodeLayout& layout, PetscInt cell, const std::array<double, 3>& xi);
Tensor3<double> gradient_in_cell(const NodeLayout& layout, PetscInt cell, const std::array<double, 3>& xi,
                                 std::span<const double> u);

/// The local cells on both sides of facets, which are on the rank of each facet that it owns; -1: none.
std::vector<std::array<PetscInt, 2>> cells_of_facets(const NodeLayout& layout, std::span<const PetscInt> facet_nodes,
                                                     int nodes_per_facet);

}  // namespace pliant
