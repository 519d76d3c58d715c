/// The part of a body's surface that may touch obstacles, and its points close to one.
#pragma once

#include "energy/contact/obstacle.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"
#include "material/contact_law.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

namespace pliant {

/// Facets (boundary faces) with quadrature points. Integrals are over the reference area. The points of a penalty are
/// those of a rule of degree 4; those of a barrier are the facet's corners, edge midpoints and centre (degree 3), so
/// that no node can pass it. Both rules are symmetric in the corners, so that ranks agree on them. Segments of rods
/// (segment_as_facet) have five points on their axes, those of Lobatto's rule, and the area of thickness times length.
class ContactSurface {
 public:
  /// `thickness`: of a rod, whose segments the facets are then [m]; 0: they are facets of the mesh. The layout outlives
  /// the object.
  ContactSurface(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets, const NormalLaw& law,
                 double thickness = 0.0);

  /// A quadrature point and its facet.
  struct Point {
    std::span<const PetscInt> nodes;       ///< of the facet
    std::span<const double> N;             ///< shape functions
    std::span<const std::int32_t> blocks;  ///< of the nodes (a, b) in the pattern; 0 in rows that are not owned
    double area = 0.0;                     ///< dA [m^2]
  };

  enum class Facets {
    with_owned_nodes,  ///< facets whose forces a rank needs
    owned,             ///< facets whose energies it counts
  };

  /// visit(point) for the points of facets that are, at one of the displacements, within reach of the obstacle. A facet
  /// lies in a ball around the mean of its nodes; the distance of its centre decides whether the ball is out of reach.
  template <class Visit>
  void for_each_near(const ObstacleFrame& obstacle, std::initializer_list<std::span<const double>> displacements,
                     Facets which, const Visit& visit) const {
    for_each_point(which, visit, [&](PetscInt facet) {
      return std::ranges::any_of(displacements, [&](const auto& q) { return is_near(facet, obstacle, q); });
    });
  }
  /// visit(point) for all points of owned facets.
  template <class Visit>
  void for_each_owned(const Visit& visit) const {
    for_each_point(Facets::owned, visit, [](PetscInt) { return true; });
  }
  /// visit(point) for the points of a facet.
  template <class Visit>
  void for_each_of(PetscInt facet, const Visit& visit) const {
    const auto n = static_cast<std::size_t>(facets_.nodes_per_facet);
    for (std::size_t k = 0; k < num_points_; ++k) {
      visit(Point{nodes_of(facet), std::span(shape_functions_).subspan(k * n, n),
                  std::span(blocks_).subspan(facet * n * n, n * n), areas_[facet * num_points_ + k]});
    }
  }

  /// A ball that contains the points of a facet.
  struct Ball {
    Vector3<double> centre{};
    double radius = 0.0;  ///< [m]
  };
  Ball ball(PetscInt facet, std::span<const double> q) const;
  /// The largest sum of |N_a| at a point: how much further it may move than its nodes.
  double overshoot() const { return overshoot_; }
  std::span<const PetscInt> nodes_of(PetscInt facet) const {
    return std::span(facets_.nodes).subspan(facet * facets_.nodes_per_facet, facets_.nodes_per_facet);
  }
  Vector3<double> position(PetscInt node, std::span<const double> q) const {
    return layout_.position(node) + Vector3<double>{q[3 * node], q[3 * node + 1], q[3 * node + 2]};
  }

  /// The position of a point at the displacement q.
  Vector3<double> position(const Point& point, std::span<const double> q) const {
    Vector3<double> x{};
    for (std::size_t a = 0; a < point.nodes.size(); ++a) {
      const PetscInt n = 3 * point.nodes[a];
      for (std::size_t i = 0; i < 3; ++i) x[i] += point.N[a] * (layout_.coordinates[n + i] + q[n + i]);
    }
    return x;
  }
  /// A nodal field at a point.
  static Vector3<double> interpolate(const Point& point, std::span<const double> values) {
    Vector3<double> x{};
    for (std::size_t a = 0; a < point.nodes.size(); ++a) {
      for (std::size_t i = 0; i < 3; ++i) x[i] += point.N[a] * values[3 * point.nodes[a] + i];
    }
    return x;
  }

  /// r_a += N_a f for owned and other local nodes.
  static void add_force(const Point& point, const Vector3<double>& f, std::span<double> r) {
    for (std::size_t a = 0; a < point.nodes.size(); ++a) {
      for (std::size_t i = 0; i < 3; ++i) r[3 * point.nodes[a] + i] += point.N[a] * f[i];
    }
  }
  /// K_ab += N_a N_b D in the rows of owned nodes.
  void add_stiffness(const Point& point, const Tensor3<double>& D, const BlockWriter& K) const;

  const NormalLaw& law() const { return law_; }
  const FacetList& facets() const { return facets_; }

 private:
  template <int Order>
  void set_points(std::span<const std::array<double, 2>> points, std::span<const double> weights);
  void set_points_of_segments(double thickness);
  template <class Visit, class Wanted>
  void for_each_point(Facets which, const Visit& visit, const Wanted& wanted) const;
  bool is_near(PetscInt facet, const ObstacleFrame& obstacle, std::span<const double> q) const;

  const NodeLayout& layout_;
  FacetList facets_;
  NormalLaw law_;
  std::vector<double> shape_functions_;  // of the points, one after another
  std::size_t num_points_ = 0;           // of a facet
  double overshoot_ = 1.0;               // the largest sum of |N_a|
  std::vector<double> areas_;            // of all points
  std::vector<std::int32_t> blocks_;     // nodes_per_facet^2 per facet
  std::vector<char> has_owned_node_;
};

template <class Visit, class Wanted>
void ContactSurface::for_each_point(Facets which, const Visit& visit, const Wanted& wanted) const {
  for (PetscInt f = 0; f < facets_.size(); ++f) {
    if ((which == Facets::owned ? facets_.is_owned[f] : has_owned_node_[f]) != 0 && wanted(f)) for_each_of(f, visit);
  }
}

}  // namespace pliant
