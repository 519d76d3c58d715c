#include "model/loads.hpp"

#include "energy/load/foundation.hpp"
#include "energy/load/load.hpp"
#include "input/analysis.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

std::unique_ptr<EnergyTerm> make_foundation(const LoadConfig& load, Analysis analysis, const LoadedBodies& bodies,
                                            Selections& selections) {
  // A static equilibrium knows no velocity.
  const double dashpot = analysis == Analysis::static_equilibrium ? 0.0 : load.dashpot.value_or(0.0);
  const FoundationStiffness stiffness{load.spring.value_or(0.0), dashpot};
  if (load.kind == LoadConfig::Kind::foundation) {
    const auto facets = selections.facets(load.part);
    return std::make_unique<Foundation>(surface_foundation(bodies.layout, bodies.pattern, facets, load.direction),
                                        stiffness);
  }
  const auto nodes = selections.nodes(load.part);
  const auto num_nodes = sum(bodies.layout.comm, static_cast<PetscInt64>(nodes.size()));
  return std::make_unique<Foundation>(nodal_foundation(bodies.pattern, nodes, 1.0 / static_cast<double>(num_nodes)),
                                      stiffness);
}

LoadSamples gravity_samples(const LoadConfig& load, MassKind mass, const LoadedBodies& bodies, Selections& selections) {
  const NodeLayout& layout = bodies.layout;
  const auto inside = selections.cells(load.part);
  std::vector<double> density(layout.num_local_cells, 0.0);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (inside[c] && bodies.body_of_cell[c] >= 0) density[c] = bodies.densities[bodies.body_of_cell[c]];
  }
  return mass == MassKind::lumped ? lumped_cell_samples(layout, density)
                                  : cell_samples(layout, density, variation_of(load.value));
}

LoadSamples volume_samples(const LoadConfig& load, const LoadedBodies& bodies, Selections& selections) {
  const auto inside = selections.cells(load.part);
  return cell_samples(bodies.layout, {inside.begin(), inside.end()}, variation_of(load.value));
}

/// Of a total force.
LoadSamples shared_samples(const LoadConfig& load, const LoadedBodies& bodies, Selections& selections) {
  const NodeLayout& layout = bodies.layout;
  const Variation variation = variation_of(load.value);
  if (load.part.kind == Selection::Kind::point) {
    const auto nodes = selections.nodes(load.part);
    return with_total_weight_one(layout, node_samples(layout, nodes), std::vector<char>(nodes.size(), 1));
  }
  if (load.part.kind == Selection::Kind::curve) {
    const auto edges = selections.edges(load.part);
    return with_total_weight_one(layout, edge_samples(layout, edges, variation), edges.is_owned);
  }
  const auto facets = selections.facets(load.part);
  return with_total_weight_one(layout, facet_samples(layout, facets, variation), facets.is_owned);
}

std::unique_ptr<EnergyTerm> make_dead_load(const LoadConfig& load, MassKind mass, const LoadedBodies& bodies,
                                           Selections& selections) {
  using Kind = LoadConfig::Kind;
  LoadSamples samples;
  switch (load.kind) {
    case Kind::gravity:
      samples = gravity_samples(load, mass, bodies, selections);
      break;
    case Kind::force_density:
      samples = volume_samples(load, bodies, selections);
      break;
    case Kind::traction:
      samples = facet_samples(bodies.layout, selections.facets(load.part), variation_of(load.value));
      break;
    case Kind::line_force:
      samples = edge_samples(bodies.layout, selections.edges(load.part), variation_of(load.value));
      break;
    default:
      samples = shared_samples(load, bodies, selections);
      break;
  }
  return std::make_unique<DeadLoad>(bodies.layout, std::move(samples), load.value);
}

}  // namespace

bool has_dashpots(const Config& config) {
  return std::ranges::any_of(config.loads, [](const LoadConfig& load) { return load.dashpot.value_or(0.0) > 0.0; });
}

Loads::Loads(const Config& config, const LoadedBodies& bodies, Selections& selections)
    : layout_(bodies.layout), pattern_(bodies.pattern), wetted_(config, selections) {
  using Kind = LoadConfig::Kind;
  for (const LoadConfig& load : config.loads) {
    if (load.kind == Kind::pressure) continue;
    const bool is_foundation = load.kind == Kind::foundation || load.kind == Kind::point_foundation;
    add(is_foundation ? make_foundation(load, analysis_of(config), bodies, selections)
                      : make_dead_load(load, config.mass, bodies, selections),
        load.where);
  }
}

void Loads::add(std::unique_ptr<EnergyTerm> term, const Location& where) {
  terms_.push_back(std::move(term));
  places_.push_back(where);
}

void Loads::complete(const Config& config, const PrescribedDisplacement& prescribed) {
  for (auto& [term, where] : wetted_.make_terms(config, layout_, pattern_, prescribed)) add(std::move(term), where);
}

void Loads::require_finite(double time) const {
  const std::vector<double> zero(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0.0);
  LocalStage stage;
  stage.time = time;
  stage.dt = 1.0;
  stage.q0 = stage.v0 = zero;
  on_every_rank(layout_.comm, [&] {
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      std::vector<double> forces(zero);
      terms_[k]->add_gradient(stage, zero, forces);
      if (std::all_of(forces.begin(), forces.end(), [](double f) { return std::isfinite(f); })) continue;
      throw InputError(places_[k], fmt::format("the load is not finite at t = {:g}", time));
    }
  });
}

}  // namespace pliant
