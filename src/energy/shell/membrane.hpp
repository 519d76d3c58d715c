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

/// The material of a layer.
struct LayerMaterial {
  ElasticLawSpec law;                                                  ///< the law itself, or its kind where it varies
  std::function<ElasticLawSpec(const std::array<double, 3>&)> law_at;  ///< at a reference position; empty: uniform
  double damping = 0.0;                                                ///< viscous resistance per stiffness [s]
};

/// The terms of a layer.
struct MembraneTerms {
  /// U = int W(f_1, f_2) dV, W the law in plane stress (energy/shell/plane_stress.hpp), V the volume of the layer as it
  /// was before it was stretched onto the facets. Every facet counts once, whichever bodies are at its sides.
  std::unique_ptr<EnergyTerm> elasticity;
  /// Resists the rates of strain in the layer in proportion to the stiffness C of plane stress at rest: S = beta C Edot
  /// with Edot_ab = (f_a.f_b' + f_b.f_a')/2, f' = (f - f_0)/dt at the end of the stage. Without a potential, so that
  /// every method keeps its order (docs/theory.md, "Strain rates and their orders"); nullptr: beta = 0.
  std::unique_ptr<EnergyTerm> viscosity;
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
