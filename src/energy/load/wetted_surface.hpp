/// A part of the outer surface under the pressure of a fluid: its nodal forces, their tangent, and the volume that the
/// surface sweeps.
#pragma once

#include "base/expression.hpp"
#include "base/vector3.hpp"
#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <array>
#include <span>
#include <vector>

namespace pliant {

/// Facets with the current positions x(xi, eta) = sum_a N_a (X_a + u_a), n = x_xi cross x_eta outward (Bonet & Wood
/// 2008, pressure forces). A pressure p that may vary over the reference surface has
///
///     r_a  = p int N_a n dxi deta
///     K_ab = p int N_a ( dN_b/deta [x_xi] - dN_b/dxi [x_eta] ) dxi deta,     [v] w = v cross w
///
/// r is p times the derivative of the swept volume, dS = int n . dx. Where p is uniform and the surface is closed, or
/// its rim sweeps nothing (Rim), r is the gradient of p S and K is symmetric.
class WettedSurface {
 public:
  /// `facets` must be outer ones. `pressure_degree`: the polynomial degree in space up to which pressures are
  /// integrated exactly. The layout must outlive the object.
  WettedSurface(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets, int pressure_degree);

  const FacetList& facets() const { return facets_; }

  /// The pressure at every point of the facets times the points' weights; the argument of the functions below.
  std::vector<double> weighted(const Expression& pressure, double time) const;
  std::vector<double> weighted(double pressure) const;

  /// int p dS along the straight line between two displacements, over this rank's facets: exact, and accurate relative
  /// to the change.
  double work(std::span<const double> pressures, std::span<const double> from, std::span<const double> to) const;
  /// r += ..., rows of local nodes; those of owned nodes are complete.
  void add_forces(std::span<const double> pressures, std::span<const double> q, std::span<double> r) const;
  /// K += ..., rows of owned nodes.
  void add_tangent(std::span<const double> pressures, std::span<const double> q, const BlockWriter& K) const;

 private:
  /// A point of the quadrature rule of a facet.
  struct Point {
    std::array<double, 6> N;
    std::array<std::array<double, 2>, 6> dN;  ///< dN_a/dxi, dN_a/deta
    double weight;
  };
  template <int Order>
  void set_rule(int pressure_degree);
  std::span<const PetscInt> nodes_of(PetscInt facet) const;
  /// x_xi and x_eta [m].
  std::array<Vector3<double>, 2> tangents(std::span<const PetscInt> nodes, const Point& at,
                                          std::span<const double> q) const;

  const NodeLayout& layout_;
  FacetList facets_;
  std::vector<Point> points_;
  std::vector<std::int32_t> blocks_;  ///< of nodes (a, b), nodes_per_facet^2 per facet; 0 in rows that are not owned
};

}  // namespace pliant
