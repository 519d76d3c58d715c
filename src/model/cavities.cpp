#include "model/cavities.hpp"

#include "energy/load/pressure.hpp"
#include "fem/rim.hpp"
#include "fem/walls.hpp"
#include "input/analysis.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Fractions of the simulated time at which rims are examined.
constexpr std::array<double, 3> looks{0.0, 0.37, 1.0};

/// The surfaces on which fluids press, each with its free shells as it sees them.
class Walls {
 public:
  Walls(const NodeLayout& layout, std::span<const char> is_shell, Selections& selections)
      : layout_(layout), is_shell_(is_shell), selections_(selections) {}

  FacetList operator()(const Selection& part, const Location& where) const {
    FacetList facets = selections_.outer_facets(part, where, "where a pressure has no side to push on");
    orient_shells_in_walls(layout_, is_shell_, facets);
    return facets;
  }

 private:
  const NodeLayout& layout_;
  std::span<const char> is_shell_;
  Selections& selections_;
};

/// The corners of a facet, the smallest first, in the order that its orientation gives: a shell between two chambers
/// has one orientation in the walls of each.
std::array<PetscInt, 3> oriented_corners(std::span<const PetscInt> nodes) {
  std::array<PetscInt, 3> corners{nodes[0], nodes[1], nodes[2]};
  std::ranges::rotate(corners, std::ranges::min_element(corners));
  return corners;
}

PrescribedSamples samples_of(const Config& config, const NodeLayout& layout, const PrescribedDisplacement& prescribed) {
  PrescribedSamples samples{prescribed.flags(), {}};
  const Handle<Vec> q = make_vector(layout), v = make_vector(layout);
  const PrescribedMotion motion = prescribed.motion();
  for (const double part : looks) {
    check(VecZeroEntries(q.get()));
    const double time = analysis_of(config) == Analysis::static_equilibrium ? config.time.end : part * config.time.end;
    motion.complete_step({time, 1.0}, q.get(), v.get());
    update_ghosts(q.get());
    const ConstGhostedView u(q.get());
    samples.displacements.emplace_back(u.span().begin(), u.span().end());
  }
  return samples;
}

struct ContentOf {
  double volume;
  const TimeConfig& time;

  CavityContent operator()(const CavityConfig::GivenPressure& pressure) const { return GivenPressure{pressure.value}; }
  CavityContent operator()(const CavityConfig::Gas& gas) const {
    return Gas{volume, gas.pressure, gas.ambient, gas.exponent, gas.amount};
  }
  CavityContent operator()(const CavityConfig::Liquid& liquid) const {
    // A static equilibrium has no step.
    const double panel = time.step > 0.0 ? time.step : time.end / 1000.0;
    return Liquid{volume, liquid.pressure, liquid.bulk_modulus, liquid.added_volume,
                  TimeIntegral(liquid.flow, time.end, panel)};
  }
};

/// The volume in the reference configuration, and what the walls surround. Throws InputError if the cavity is open.
ModelCavity measured(const CavityConfig& cavity, const NodeLayout& layout, const FacetList& walls,
                     std::vector<RimEdge>& edges, const PrescribedSamples& samples) {
  const Rim rim = classify(layout, edges, samples);
  if (rim == Rim::free || rim == Rim::moving) {
    const auto places = places_of(rim, layout, edges, samples);
    const auto& [x, y, z] = places.front();
    throw InputError(cavity.where,
                     fmt::format("the cavity '{}' is open: the edge of {} {} ({} edges of its facets, the first near "
                                 "({:.4g}, {:.4g}, {:.4g}) m); close the surface, hold its edge at displacement 0, or "
                                 "let it slide in planes of constant x, y or z",
                                 cavity.name, describe(cavity.part), rim == Rim::free ? "can move" : "moves",
                                 places.size(), x, y, z));
  }
  if (!planes_close(layout, edges)) {
    throw InputError(cavity.where,
                     fmt::format("the cavity '{}' is open: the edge of {} slides along its walls, and no lid goes with "
                                 "it; close the end with facets (of a body, or of a free shell), or hold the edge at "
                                 "displacement 0",
                                 cavity.name, describe(cavity.part)));
  }
  const auto behind_or_not = volume_behind(layout, walls, edges);
  const auto* surrounded = std::get_if<double>(&behind_or_not);
  if (cavity.volume) {
    return {cavity.name, nullptr, *cavity.volume, surrounded != nullptr ? std::optional(*surrounded) : std::nullopt};
  }
  if (const auto* unknown = std::get_if<UnknownLid>(&behind_or_not)) {
    const std::string why =
        unknown->direction ? fmt::format("is open between two parallel planes ({0} = {1:.6g} m and {0} = {2:.6g} m)",
                                         "xyz"[*unknown->direction], std::ranges::min(unknown->places),
                                         std::ranges::max(unknown->places))
                           : std::string(
                                 "ends at an edge that slides in part, and what is held of it lies in no plane "
                                 "(between two planes in which it "
                                 "slides: in none of constant x, y or z)");
    throw InputError(cavity.where, fmt::format("the cavity '{}' {}, so that its volume does not follow from its walls; "
                                               "give its `volume`",
                                               cavity.name, why));
  }
  const double behind = *surrounded;
  if (behind <= 0.0) {
    throw InputError(
        cavity.where,
        fmt::format("{} encloses no cavity: the volume that it faces is {:.3g} m^3, because its normals, "
                    "which point out of the material, point outwards from what it surrounds; name only the "
                    "inner faces, which surround the hollow, as a physical surface of their own, or turn a "
                    "shell round. A fluid around a body, in a container, needs its `volume`",
                    describe(cavity.part), behind));
  }
  return {cavity.name, nullptr, behind, behind};
}

}  // namespace

WettedParts find_wetted_parts(const Config& config, const NodeLayout& layout, std::span<const char> is_shell,
                              Selections& selections) {
  WettedParts parts;
  const Walls walls_of(layout, is_shell, selections);
  for (const LoadConfig& load : config.loads) {
    if (!std::holds_alternative<LoadConfig::Pressure>(load.kind)) continue;
    parts.of_pressures.push_back(walls_of(load.part, load.where));
  }
  for (const CavityConfig& cavity : config.cavities) {
    parts.of_cavities.push_back(walls_of(cavity.part, cavity.where));
  }
  return parts;
}

std::vector<Diagnostic> warnings_about_shared_walls(const Config& config, const NodeLayout& layout,
                                                    const WettedParts& parts) {
  const std::vector<FacetList>& walls = parts.of_cavities;
  std::vector<std::pair<std::array<PetscInt, 3>, std::size_t>> facets;  // each with its cavity
  for (std::size_t c = 0; c < walls.size(); ++c) {
    for (PetscInt f = 0; f < walls[c].size(); ++f) {
      if (walls[c].is_owned[f]) facets.emplace_back(oriented_corners(walls[c].nodes_of(f)), c);
    }
  }
  std::ranges::sort(facets);
  std::vector<double> num_shared(walls.size() * walls.size());  // by pairs of cavities
  for (std::size_t k = 1; k < facets.size(); ++k) {
    if (facets[k].first == facets[k - 1].first) ++num_shared[facets[k - 1].second * walls.size() + facets[k].second];
  }
  sum_in_place(layout.comm, num_shared);
  std::vector<Diagnostic> warnings;
  for (std::size_t pair = 0; pair < num_shared.size(); ++pair) {
    if (num_shared[pair] == 0.0) continue;
    const CavityConfig &one = config.cavities[pair / walls.size()], &other = config.cavities[pair % walls.size()];
    warnings.push_back({Severity::warning, other.where,
                        fmt::format("the cavities '{}' and '{}' have {:.0f} facets of their walls in common, and both "
                                    "press there; is another surface meant?",
                                    one.name, other.name, num_shared[pair])});
  }
  return warnings;
}

std::vector<Diagnostic> warnings_about_given_volumes(const Config& config, std::span<const ModelCavity> cavities) {
  constexpr double far_above = 100.0, flat = 1e-8;  // a flat wall surrounds rounding errors
  std::vector<Diagnostic> warnings;
  for (std::size_t c = 0; c < cavities.size(); ++c) {
    const CavityConfig& given = config.cavities[c];
    const std::optional<double> enclosed = cavities[c].enclosed;
    if (!given.volume || !enclosed || std::abs(*enclosed) < flat * *given.volume) continue;
    const auto warn = [&](const std::string& text) {
      warnings.push_back({Severity::warning, given.where, fmt::format("the cavity '{}' {}", given.name, text)});
    };
    if (*enclosed < 0.0) {
      warn(
          fmt::format("presses on {} from outside, as a fluid does that is around a body in a container: the normals, "
                      "which point out of the material, point outwards from the {:.3g} m^3 that it surrounds; for what "
                      "is inside, name the inner faces, or turn a shell round",
                      describe(given.part), -*enclosed));
    } else if (*given.volume > far_above * *enclosed) {
      warn(fmt::format("has a `volume` of {:.3g} m^3, and its walls surround {:.3g} m^3; is it in m^3?", *given.volume,
                       *enclosed));
    }
  }
  return warnings;
}

WettedTerms make_wetted_terms(const Config& config, const NodeLayout& layout, const BlockPattern& pattern,
                              WettedParts parts, const PrescribedDisplacement& prescribed) {
  WettedTerms result;
  if (parts.of_pressures.empty() && parts.of_cavities.empty()) return result;
  const PrescribedSamples samples = samples_of(config, layout, prescribed);
  std::size_t k = 0;
  for (const LoadConfig& load : config.loads) {
    const auto* pressure = std::get_if<LoadConfig::Pressure>(&load.kind);
    if (pressure == nullptr) continue;
    FacetList& facets = parts.of_pressures[k++];
    auto edges = rim_edges(layout, facets);
    const Rim rim = classify(layout, edges, samples);
    result.terms.push_back(
        {std::make_unique<FollowerPressure>(layout, pattern, std::move(facets), pressure->value, rim), load.where});
  }
  for (std::size_t c = 0; c < config.cavities.size(); ++c) {
    const CavityConfig& cavity = config.cavities[c];
    FacetList& walls = parts.of_cavities[c];
    auto edges = rim_edges(layout, walls);
    ModelCavity made = measured(cavity, layout, walls, edges, samples);
    auto term = std::make_unique<Cavity>(WettedSurface(layout, pattern, std::move(walls), 0),
                                         std::visit(ContentOf{made.volume, config.time}, cavity.content));
    made.term = term.get();
    result.cavities.push_back(std::move(made));
    result.terms.push_back({std::move(term), cavity.where});
  }
  return result;
}

}  // namespace pliant
