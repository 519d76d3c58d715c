/// Strain energy of a body: U = int psi(grad u) dX.
#pragma once

#include "energy/stress.hpp"
#include "energy/volume/expansion.hpp"
#include "fem/cells.hpp"
#include "material/law_field.hpp"

#include <functional>
#include <memory>
#include <variant>

namespace pliant {

/// A displacement, and its gradient recovered at the nodes (fem/patch_recovery.hpp), in arrays of local nodes.
struct RecoveredState {
  Instant at = {};
  std::span<const double> X;          ///< reference positions [m]
  std::span<const double> q;          ///< displacement [m]
  std::span<const double> gradients;  ///< nine numbers per node, row by row
};

/// The error of a cell (energy/volume/recovery_error.hpp).
struct RecoveryError {
  double energy = 0.0;  ///< [J]
  double volume = 0.0;  ///< of the cell [m^3]
};
/// Called with a local cell.
using RecoveryErrorVisitor = std::function<void(PetscInt, const RecoveryError&)>;

/// The elastic term of one body; its stresses are evaluated at the centroids.
class ElasticTerm : public StressTerm {
 public:
  StressPart part() const final { return StressPart::elastic; }
  /// Calls `visit` for each local cell of the term.
  virtual void recovery_errors(const RecoveredState& state, const RecoveryErrorVisitor& visit) const = 0;
};

/// `groups` holds the cells of all bodies and must outlive the term; those of `body` belong to the term. The packs of
/// `law` are the body's quadrature points (CellPoint::index).
template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(std::shared_ptr<const LawField> law, const CellGroups<Order>& groups,
                                               int body, PetscInt num_owned_nodes, FreeShape shape = {});

/// Likewise for a uniform body.
template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(const ElasticLawSpec& law, const CellGroups<Order>& groups, int body,
                                               PetscInt num_owned_nodes) {
  return make_elastic_term<Order>(make_law_field(law), groups, body, num_owned_nodes);
}

/// The laws of a body whose parameters vary in space: `at(local cell, reference position)`, all of the kind of
/// `common`.
template <int Order>
std::unique_ptr<LawField> make_varying_law(
    const ElasticLawSpec& common, const NodeLayout& layout, const CellGroups<Order>& groups, int body,
    const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>& at);

/// Degree of the quadrature rule for a law on elements of the order: exact on affine cells if psi is a polynomial of H,
/// else one point per linear and four per quadratic tetrahedron.
int elastic_quadrature_degree(const LawTraits& law, int order);

}  // namespace pliant
