#include "app/loads.hpp"

#include "app/model.hpp"
#include "energy/load.hpp"
#include "energy/pressure.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

std::unique_ptr<EnergyTerm> make_pressure(const LoadConfig& load, const LoadedBodies& bodies, Selections& selections) {
  FacetList facets = selections.facets(load.part);
  if (any(bodies.layout.comm, std::ranges::find(facets.is_outer, 0) != facets.is_outer.end())) {
    selections.report(load.where, fmt::format("{} lies inside the mesh, where a pressure has no side to push on; "
                                              "name a part of the outer surface",
                                              describe(load.part)));
    return nullptr;
  }
  return std::make_unique<FollowerPressure>(bodies.layout, bodies.pattern, std::move(facets), load.pressure);
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

}  // namespace

std::vector<std::unique_ptr<EnergyTerm>> make_loads(const Config& config, const LoadedBodies& bodies,
                                                    Selections& selections) {
  std::vector<std::unique_ptr<EnergyTerm>> terms;
  for (const LoadConfig& load : config.loads) {
    if (load.kind == LoadConfig::Kind::pressure) {
      terms.push_back(make_pressure(load, bodies, selections));
      continue;
    }
    LoadSamples samples = load.kind == LoadConfig::Kind::traction
                              ? facet_samples(bodies.layout, selections.facets(load.part), variation_of(load.value))
                              : gravity_samples(load, config.mass, bodies, selections);
    terms.push_back(std::make_unique<DeadLoad>(bodies.layout, std::move(samples), load.value));
  }
  return terms;
}

void check_finite(const std::vector<std::unique_ptr<EnergyTerm>>& loads, const Config& config,
                  const NodeLayout& layout) {
  const std::vector<double> zero(3 * static_cast<std::size_t>(layout.num_local_nodes), 0.0);
  LocalStage stage;
  stage.time = analysis_of(config) == Analysis::static_equilibrium ? config.time.end : 0.0;
  stage.dt = 1.0;
  stage.q0 = stage.v0 = zero;
  on_every_rank(layout.comm, [&] {
    for (std::size_t k = 0; k < loads.size(); ++k) {
      std::vector<double> forces(zero);
      loads[k]->add_gradient(stage, zero, forces);
      if (std::all_of(forces.begin(), forces.end(), [](double f) { return std::isfinite(f); })) continue;
      throw InputError(config.loads[k].where, fmt::format("the load is not finite at t = {:g}", stage.time));
    }
  });
}

}  // namespace pliant
