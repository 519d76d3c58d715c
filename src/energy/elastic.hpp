/// Strain energy of a body: U = int psi(grad u) dX.
#pragma once

#include "energy/activation.hpp"
#include "fem/cells.hpp"
#include "material/law_field.hpp"

#include <functional>
#include <memory>
#include <variant>

namespace pliant {

/// Stress and related quantities at the centroid of a cell.
struct CellStress {
  std::array<double, 6> cauchy;  ///< xx yy zz xy yz xz [Pa]
  double von_mises;              ///< [Pa]
  double volume_ratio;           ///< J
  double energy_density;         ///< per reference volume [J/m^3]
};

/// The elastic term of one body.
class ElasticTerm : public EnergyTerm {
 public:
  /// Calls `visit(local cell, stress)` for each owned cell.
  virtual void stresses(const Instant& at, std::span<const double> q,
                        const std::function<void(PetscInt, const CellStress&)>& visit) const = 0;
};

/// `groups` holds all bodies' cells and outlives the term; those of `body` are the term's. The packs of `law` are the
/// body's quadrature points (CellPoint::index). `shortening`, if given, is the active strain of its fibres.
template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(std::shared_ptr<const LawField> law, const CellGroups<Order>& groups,
                                               int body, PetscInt num_owned_nodes,
                                               std::shared_ptr<const Activation> shortening = nullptr);

/// The same of a uniform body.
template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(const ElasticLawSpec& law, const CellGroups<Order>& groups, int body,
                                               PetscInt num_owned_nodes) {
  return make_elastic_term<Order>(make_law_field(law), groups, body, num_owned_nodes);
}

/// The laws of a body whose parameters differ from place to place: `at(local cell, reference position)`, all of the
/// kind of `common`.
template <int Order>
std::unique_ptr<LawField> make_varying_law(
    const ElasticLawSpec& common, const NodeLayout& layout, const CellGroups<Order>& groups, int body,
    const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>& at);

/// Degree of the quadrature rule for a law on elements of the order: exact on affine cells if psi is a polynomial of H,
/// else one point per linear and four per quadratic tetrahedron.
int elastic_quadrature_degree(const LawTraits& law, int order);

}  // namespace pliant
