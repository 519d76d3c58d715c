/// Strain energy of a body: U = int psi(grad u) dX.
#pragma once

#include "energy/term.hpp"
#include "fem/cells.hpp"
#include "material/registry.hpp"

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

/// The elastic term of one body; its law is a template parameter of the implementation, so that the loops over cells
/// are inlined.
class ElasticTerm : public EnergyTerm {
 public:
  /// Calls `visit(local cell, stress)` for each owned cell.
  virtual void stresses(std::span<const double> q,
                        const std::function<void(PetscInt, const CellStress&)>& visit) const = 0;
};

/// `groups` holds all bodies' cells and outlives the term; those of `body` are the term's.
template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(const ElasticLawVariant& law, const CellGroups<Order>& groups, int body,
                                               PetscInt num_owned_nodes);

/// Degree of the quadrature rule for a law on elements of the order: exact on affine cells if psi is a polynomial of H,
/// else one point per linear and four per quadratic tetrahedron.
int elastic_quadrature_degree(const ElasticLawVariant& law, int order);

}  // namespace pliant
