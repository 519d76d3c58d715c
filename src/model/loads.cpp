#include "model/loads.hpp"

#include "base/text.hpp"
#include "energy/load/body_torque.hpp"
#include "energy/load/foundation.hpp"
#include "energy/load/load.hpp"
#include "input/analysis.hpp"
#include "input/loads.hpp"
#include "model/rigid_bodies.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <string>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The terms of all kinds of loads but pressures, which depend on constraints (model/cavities); nullptr for those.
class LoadTerms {
 public:
  using Term = std::unique_ptr<EnergyTerm>;

  LoadTerms(const Config& config, const LoadedBodies& bodies, Selections& selections)
      : config_(config), bodies_(bodies), selections_(selections) {}

  Term operator()(const LoadConfig& load) const {
    return std::visit([&](const auto& kind) { return make(kind, load); }, load.kind);
  }
  /// The weight of rods; nothing if the load has none of it.
  Term weight_of_rods(const LoadConfig& load) const {
    const auto* gravity = std::get_if<LoadConfig::Gravity>(&load.kind);
    if (gravity == nullptr || bodies_.rods.rods.empty()) return nullptr;
    std::vector<char> pulled(bodies_.rods.lengths.size(), 0);
    bool any = false;
    for (const ModelRod& rod : bodies_.rods.rods) {
      const bool is_meant = load.part.kind == Selection::Kind::everything ||
                            (load.part.kind == Selection::Kind::volume && load.part.name == rod.name);
      if (!is_meant) continue;
      any = true;
      std::fill_n(pulled.begin() + static_cast<std::ptrdiff_t>(rod.first_segment), rod.num_segments(), char{1});
    }
    if (!any) return nullptr;
    return dead_load(samples_of(bodies_.rods.masses(pulled)), gravity->acceleration);
  }
  /// The weight of shells, on which gravity acts where it acts on all bodies, and of a free one by its name.
  Term weight_of_shell(const LoadConfig& load, const ModelShell& shell) const {
    const auto* gravity = std::get_if<LoadConfig::Gravity>(&load.kind);
    const bool is_free = std::ranges::find(config_.shells, shell.name, &ShellConfig::name)->is_free;
    const bool is_named = load.part.kind == Selection::Kind::volume && load.part.name == shell.name;
    const bool is_meant = load.part.kind == Selection::Kind::everything || (is_free && is_named);
    if (gravity == nullptr || !is_meant || shell.mass_per_area == 0.0) return nullptr;
    const NodeLayout& layout = bodies_.layout;
    if (config_.mass == MassKind::lumped) {
      const std::vector<double> masses = lumped_masses_of_layer(layout, shell.facets, shell.mass_per_area);
      LoadSamples samples = node_samples(layout, shell.facets.nodes);
      samples.weights = masses;
      return dead_load(std::move(samples), gravity->acceleration);
    }
    LoadSamples samples = facet_samples(layout, shell.facets, variation_of(gravity->acceleration));
    for (double& weight : samples.weights) weight *= shell.mass_per_area;
    return dead_load(std::move(samples), gravity->acceleration);
  }
  /// The weight of `rigid_bodies`; nothing if the load has none of it.
  Term weight_of_rigid_bodies(const LoadConfig& load) const {
    const auto* gravity = std::get_if<LoadConfig::Gravity>(&load.kind);
    if (gravity == nullptr || config_.rigid_bodies.empty()) return nullptr;
    auto bodies = masses_of_rigid_bodies(config_);
    if (load.part.kind != Selection::Kind::everything) {
      std::erase_if(bodies, [&](const AffineBody& body) {
        const Selection& part = config_.bodies[static_cast<std::size_t>(body.body)].part;
        return part.kind != load.part.kind || part.name != load.part.name;
      });
    }
    if (bodies.empty()) return nullptr;
    return dead_load(samples_at_centres(bodies), gravity->acceleration);
  }

 private:
  Term make(const LoadConfig::Gravity& gravity, const LoadConfig& load) const {
    const NodeLayout& layout = bodies_.layout;
    const auto inside = selections_.cells(load.part);
    std::vector<double> density(layout.num_local_cells, 0.0);
    for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
      if (inside[c] && bodies_.body_of_cell[c] >= 0) density[c] = bodies_.densities[bodies_.body_of_cell[c]];
    }
    return dead_load(config_.mass == MassKind::lumped
                         ? lumped_cell_samples(layout, density)
                         : cell_samples(layout, density, variation_of(gravity.acceleration)),
                     gravity.acceleration);
  }
  Term make(const LoadConfig::ForceDensity& force, const LoadConfig& load) const {
    auto inside = selections_.cells(load.part);
    // Bodies without a mesh have no volume.
    bool has_cells = false, has_volume = false;
    for (std::size_t c = 0; c < inside.size(); ++c) {
      has_cells = has_cells || inside[c] != 0;
      if (stands_for_body(config_, bodies_.body_of_cell[c])) inside[c] = 0;
      has_volume = has_volume || inside[c] != 0;
    }
    const bool is_found = any_rank(bodies_.layout.comm, has_cells);  // or that is an error already
    if (!any_rank(bodies_.layout.comm, has_volume) && is_found) {
      selections_.report(load.where,
                         "'force_density' acts on the volume of tetrahedra, and there are none here: use 'gravity', or "
                         "'traction' on surfaces and 'line_force' on curves");
    }
    return dead_load(cell_samples(bodies_.layout, {inside.begin(), inside.end()}, variation_of(force.value)),
                     force.value);
  }
  Term make(const LoadConfig::Traction& traction, const LoadConfig& load) const {
    return dead_load(facet_samples(bodies_.layout, selections_.facets(load.part), variation_of(traction.value)),
                     traction.value);
  }
  Term make(const LoadConfig::LineForce& force, const LoadConfig& load) const {
    return dead_load(edge_samples(bodies_.layout, selections_.edges(load.part), variation_of(force.value)),
                     force.value);
  }
  Term make(const LoadConfig::Force& force, const LoadConfig& load) const {
    if (load.part.kind == Selection::Kind::volume) {
      const auto body = rigid_body(load);
      if (!body) return nullptr;
      const auto [mass, center] =
          mass_of_rigid_body(config_, bodies_.layout, bodies_.body_of_cell, bodies_.shells, *body);
      const AffineBody unit{*body, 1.0, center, {}};
      return dead_load(samples_at_centres(std::span(&unit, 1)), force.value);
    }
    return dead_load(shared_samples(load.part, variation_of(force.value)), force.value);
  }
  Term make(const LoadConfig::Torque& torque, const LoadConfig& load) const {
    const auto body = rigid_body(load);
    if (!body) return nullptr;
    return std::make_unique<BodyTorque>(bodies_.layout, largest_cell_of(bodies_.layout, bodies_.body_of_cell, *body),
                                        torque.value);
  }
  Term make(const LoadConfig::Pressure&, const LoadConfig&) const { return nullptr; }
  Term make(const LoadConfig::Foundation& foundation, const LoadConfig& load) const {
    const auto facets = selections_.facets(load.part);
    return std::make_unique<Foundation>(
        surface_foundation(bodies_.layout, bodies_.pattern, facets, foundation.direction), stiffness_of(load));
  }
  Term make(const LoadConfig::PointFoundation&, const LoadConfig& load) const {
    const auto nodes = selections_.nodes(load.part);
    const auto num_nodes = sum(bodies_.layout.comm, static_cast<PetscInt64>(nodes.size()));
    return std::make_unique<Foundation>(nodal_foundation(bodies_.pattern, nodes, 1.0 / static_cast<double>(num_nodes)),
                                        stiffness_of(load));
  }

  /// Samples of the masses of bodies at their centres.
  LoadSamples samples_at_centres(std::span<const AffineBody> bodies) const {
    return samples_of(masses_of_affine_bodies(bodies_.layout, bodies_.body_of_cell, bodies));
  }
  static LoadSamples samples_of(const std::vector<MassAtNode>& masses) {
    LoadSamples samples{1, 1, {}, {}, {{1.0}}, {}, {}};
    for (const auto& [node, mass, centre] : masses) {
      samples.nodes.push_back(node);
      samples.points.push_back(centre);
      samples.weights.push_back(mass);
    }
    return samples;
  }
  /// The number of the rigid body on which the load acts; nothing, with an error, if it is none.
  std::optional<int> rigid_body(const LoadConfig& load) const {
    std::vector<std::string> known;
    for (std::size_t b = 0; b < config_.bodies.size(); ++b) {
      const BodyConfig& body = config_.bodies[b];
      if (!body.is_rigid || body.part.kind != Selection::Kind::volume) continue;
      if (body.part.name == load.part.name) return static_cast<int>(b);
      known.push_back(body.part.name);
    }
    const auto is_it = [&](const BodyConfig& body) {
      return body.part.kind == Selection::Kind::volume && body.part.name == load.part.name;
    };
    const std::string instead =
        std::ranges::none_of(config_.bodies, is_it) ? did_you_mean(load.part.name, known)
        : std::holds_alternative<LoadConfig::Torque>(load.kind)
            ? "; on a soft body: a 'torque' on one of 'rigid_bodies' that a surface of it is 'coupled' to"
            : "; on a soft body: 'force' on a 'surface', 'curve' or 'point' of it, or 'force_density' [N/m^3] on the "
              "volume";
    selections_.report(load.part.where,
                       fmt::format("{} is not a rigid body, and only those take a force or torque as a whole{}; rigid "
                                   "bodies are: {}",
                                   describe(load.part), instead, known.empty() ? "none" : joined(known)));
    return std::nullopt;
  }

  Term dead_load(LoadSamples samples, const VectorExpression& value) const {
    return std::make_unique<DeadLoad>(bodies_.layout, std::move(samples), value);
  }
  /// Samples of a total force that is spread over the part.
  LoadSamples shared_samples(const Selection& part, Variation variation) const {
    const NodeLayout& layout = bodies_.layout;
    if (part.kind == Selection::Kind::point) {
      const auto nodes = selections_.nodes(part);
      return with_total_weight_one(layout, node_samples(layout, nodes), std::vector<char>(nodes.size(), 1));
    }
    if (part.kind == Selection::Kind::curve) {
      const auto edges = selections_.edges(part);
      return with_total_weight_one(layout, edge_samples(layout, edges, variation), edges.is_owned);
    }
    const auto facets = selections_.facets(part);
    return with_total_weight_one(layout, facet_samples(layout, facets, variation), facets.is_owned);
  }
  /// A static equilibrium has no velocity.
  FoundationStiffness stiffness_of(const LoadConfig& load) const {
    const FoundationCoefficients given = foundation_of(load).value();
    return {given.spring, analysis_of(config_) == Analysis::static_equilibrium ? 0.0 : given.dashpot};
  }

  const Config& config_;
  const LoadedBodies& bodies_;
  Selections& selections_;
};

}  // namespace

bool has_dashpots(const Config& config) {
  return std::ranges::any_of(config.loads, [](const LoadConfig& load) {
    return foundation_of(load).value_or(FoundationCoefficients{}).dashpot > 0.0;
  });
}

LoadParts find_loads(const Config& config, const LoadedBodies& bodies, Selections& selections) {
  LoadParts parts{
      {}, find_wetted_parts(config, bodies.layout, cells_of_free_shells(config, bodies.body_of_cell), selections)};
  const LoadTerms term_of(config, bodies, selections);
  for (const LoadConfig& load : config.loads) {
    if (auto term = term_of(load)) parts.terms.push_back({std::move(term), load.where});
    if (auto term = term_of.weight_of_rigid_bodies(load)) parts.terms.push_back({std::move(term), load.where});
    if (auto term = term_of.weight_of_rods(load)) parts.terms.push_back({std::move(term), load.where});
    for (const ModelShell& shell : bodies.shells.shells) {
      if (auto term = term_of.weight_of_shell(load, shell)) parts.terms.push_back({std::move(term), load.where});
    }
  }
  return parts;
}

Loads::Loads(const Config& config, const NodeLayout& layout, const BlockPattern& pattern, LoadParts parts,
             const PrescribedDisplacement& prescribed)
    : layout_(layout), terms_(std::move(parts.terms)) {
  WettedTerms wetted = make_wetted_terms(config, layout, pattern, std::move(parts.wetted), prescribed);
  std::ranges::move(wetted.terms, std::back_inserter(terms_));
  cavities_ = std::move(wetted.cavities);
}

void Loads::require_finite(double time) const {
  const std::vector<double> zero(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0.0);
  LocalStage stage;
  stage.time = time;
  stage.dt = 1.0;
  stage.q0 = stage.v0 = zero;
  on_every_rank(layout_.comm, [&] {
    for (const auto& [term, where] : terms_) {
      std::vector<double> forces(zero);
      term->add_gradient(stage, zero, forces);
      if (std::all_of(forces.begin(), forces.end(), [](double f) { return std::isfinite(f); })) continue;
      throw InputError(where, fmt::format("the load is not finite at t = {:g}", time));
    }
  });
}

}  // namespace pliant
