/// Membranes: thin layers on facets, which resist stretch and shear in their plane.
#pragma once

#include "energy/shell/layer_shape.hpp"
#include "energy/term.hpp"
#include "energy/volume/mass_matrix.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"
#include "material/elastic_law.hpp"

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace pliant {

/// Resistances of a layer to rates of strain Edot in its plane. No stress acts across the layer, of these neither.
struct LayerViscosity {
  double damping = 0.0;  ///< relative to the stiffness at rest [s]
  double shear = 0.0;    ///< 2 shear dev(Edot) + bulk tr(Edot) I, of Edot in three dimensions [Pa s]
  double bulk = 0.0;     ///< [Pa s]

  /// In plane stress: S_ab = trace Edot_cc delta_ab + 2 shear Edot_ab [Pa s].
  double trace() const {
    const double lambda = bulk - 2.0 / 3.0 * shear;
    return shear > 0.0 ? 2.0 * shear * lambda / (lambda + 2.0 * shear) : 0.0;
  }
  bool is_any() const { return damping > 0.0 || shear > 0.0; }
};

/// The material of a layer.
struct LayerMaterial {
  ElasticLawSpec law;                                                  ///< the law itself, or its kind where it varies
  std::function<ElasticLawSpec(const std::array<double, 3>&)> law_at;  ///< at a reference position; empty: uniform
  LayerViscosity viscosity;
};

/// A term with a stress in the layer.
class LayerTerm : public EnergyTerm {
 public:
  /// N += the mean of its force per length of the deformed layer over each facet of the list at displacements q and
  /// velocities v of the local nodes, xx yy zz xy yz xz [N/m]. v: empty where nothing moves.
  virtual void add_forces_per_length(std::span<const double> q, std::span<const double> v,
                                     std::span<std::array<double, 6>> N) const = 0;
};

/// The terms of a layer.
struct MembraneTerms {
  /// U = int W(f_1, f_2) dV, W the law in plane stress (energy/shell/plane_stress.hpp), V the volume of the layer as it
  /// was before it was stretched onto the facets. Every facet counts once, whichever bodies are at its sides.
  std::unique_ptr<LayerTerm> elasticity;
  /// Resists the rates of strain in the layer by S = beta C Edot + S_v, C the stiffness of plane stress at rest,
  /// with Edot_ab = (f_a.f_b' + f_b.f_a')/2, f' = (f - f_0)/dt at the end of the stage. Without a potential, so that
  /// every method keeps its order (docs/theory.md, "Strain rates and their orders"); nullptr: none.
  std::unique_ptr<LayerTerm> viscosity;
};

/// `facets`: 3 or 6 nodes each, as the elements of the layout have them. Throws std::domain_error as LayerFacets does.
/// Not collective.
MembraneTerms make_membrane(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                            const LayerShape& shape, const LayerMaterial& material);

/// Adds int rho N_a N_b dV, or of lumped masses the part of each node in proportion to the diagonal of that. Not
/// collective.
void add_masses_of_layer(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                         double mass_per_area, Mass kind, MassMatrix& mass);
/// The masses of each node of each facet, as they are lumped [kg]. Not collective.
std::vector<double> lumped_masses_of_layer(const NodeLayout& layout, const FacetList& facets, double mass_per_area);

}  // namespace pliant
