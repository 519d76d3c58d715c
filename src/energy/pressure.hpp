/// Follower pressure: acts along the current normal on the current area, so its forces turn and grow with the body.
#pragma once

#include "base/expression.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <array>
#include <vector>

namespace pliant {

/// Forces on the nodes of a facet with the current positions x(xi, eta) = sum_a N_a (X_a + u_a) (Bonet & Wood 2008,
/// pressure forces):
///
///     f_a  = -p int N_a n dxi deta,     n = x_xi cross x_eta, outward
///     K_ab =  p int N_a ( dN_b/deta [x_xi] - dN_b/dxi [x_eta] ) dxi deta,     [v] w = v cross w
///
/// K is unsymmetric: what is antisymmetric belongs to the edge of the loaded surface. Where that is closed or its edge
/// is held, a uniform pressure has the potential p V, and K is symmetric; the term is treated as circulatory there too.
class FollowerPressure final : public EnergyTerm {
 public:
  /// `pressure` [Pa], a function of X and t, presses inward where positive. `facets` are outer ones. The layout
  /// outlives the object.
  FollowerPressure(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets, Expression pressure);

  std::string_view name() const override { return "pressure"; }
  TermDeclaration declaration() const override {
    return {.is_potential = false, .symmetry = Symmetry::unsymmetric, .account = Account::load};
  }
  /// Zero: there is no potential.
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  /// K as above; nothing if it is to be projected: the load then stands still while the solid gives way.
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;

 private:
  /// A point of the quadrature rule of a facet.
  struct Point {
    std::array<double, 6> N;
    std::array<std::array<double, 2>, 6> dN;  ///< dN_a/dxi, dN_a/deta
    double weight;
  };
  template <int Order>
  void set_rule();
  std::span<const PetscInt> nodes_of(PetscInt facet) const;
  /// x_xi and x_eta [m].
  std::array<std::array<double, 3>, 2> tangents(std::span<const PetscInt> nodes, const Point& at,
                                                std::span<const double> q) const;
  /// Weight times p at every point of every facet, at the stage's time.
  std::vector<double> weighted_pressures(const LocalStage& stage) const;

  const NodeLayout& layout_;
  FacetList facets_;
  Expression pressure_;
  std::vector<Point> points_;
  std::vector<std::int32_t> blocks_;  ///< of nodes (a, b), nodes_per_facet^2 per facet; rows that are not owned: 0
};

}  // namespace pliant
