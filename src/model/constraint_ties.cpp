#include "model/constraint_ties.hpp"

#include "energy/constraint/surface_ties.hpp"
#include "energy/constraint/tie_elimination.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "input/analysis.hpp"
#include "model/tied_surfaces.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

using Periodic = ConstraintConfig::Periodic;
using Equation = ConstraintConfig::Equation;

/// An equation couples all its entries with one another in the Hessian.
constexpr std::size_t most_entries_of_equation = 1000;

std::string counted_nodes(std::size_t number) {
  return fmt::format("{} node{}", number, number == 1 ? "" : "s");
}

std::vector<LinearConstraint> periodic_ties(const ConstraintsOnMesh& constraints, std::size_t c,
                                            Selections& selections) {
  const auto& [config, layout, parts] = constraints;
  const ConstraintConfig& constraint = config.constraints[c];
  const Selection& partner = std::get<Periodic>(constraint.kind).partner;
  if (constraint.part.kind == partner.kind && constraint.part.name == partner.name) {
    selections.report(partner.where, fmt::format("{} cannot repeat itself; name another surface", describe(partner)));
    return {};
  }
  const auto partners = selections.nodes(partner);
  const PeriodicPairs pairs = match_periodic(layout, partners, parts[c].nodes);
  const std::size_t num_unmatched = pairs.num_unmatched_a + pairs.num_unmatched_b;
  if (num_unmatched > 0) {
    const auto& [x, y, z] = pairs.unmatched;
    const auto& [dx, dy, dz] = pairs.translation;
    selections.report(
        partner.where,
        fmt::format("{} of {} and {} of {} have no partner when one is shifted by ({:g}, {:g}, {:g}) onto "
                    "the other, the first at ({:g}, {:g}, {:g}); their meshes must be copies of each "
                    "other (gmsh: `Periodic Surface`)",
                    counted_nodes(pairs.num_unmatched_b), describe(constraint.part),
                    counted_nodes(pairs.num_unmatched_a), describe(partner), dx, dy, dz, x, y, z));
  }
  return periodic(pairs, parts[c].displacement, c);
}

std::vector<LinearConstraint> equation_ties(const ConstraintsOnMesh& constraints, std::size_t c,
                                            Selections& selections) {
  const auto& [config, layout, parts] = constraints;
  const ConstraintConfig& constraint = config.constraints[c];
  std::vector<MeanTerm> terms;
  for (const EquationTermConfig& term : std::get<Equation>(constraint.kind).terms) {
    terms.push_back({selections.nodes(term.part), term.component, term.coefficient});
  }
  LinearConstraint result = tie_of_means(layout, terms, c);
  if (result.entries.size() > most_entries_of_equation) {
    selections.report(constraint.where, fmt::format("the equation has {} entries, which it couples all with one "
                                                    "another; choose at most {} nodes",
                                                    result.entries.size(), most_entries_of_equation));
  }
  return {std::move(result)};
}

/// This rank's part of all ties of single displacements. Those that every rank knows are added on the first rank only.
std::vector<LinearConstraint> single_ties(const ConstraintsOnMesh& constraints, Selections& selections) {
  const auto& [config, layout, parts] = constraints;
  std::vector<LinearConstraint> result;
  const auto add = [&](std::vector<LinearConstraint> more) { std::ranges::move(more, std::back_inserter(result)); };
  const bool is_first = rank(layout.comm) == 0;
  for (std::size_t c = 0; c < parts.size(); ++c) {
    const ConstraintConfig& constraint = config.constraints[c];
    const ConstraintPart& part = parts[c];
    if (part.rotation || std::holds_alternative<ConstraintConfig::Tied>(constraint.kind)) continue;
    if (std::holds_alternative<ConstraintConfig::Rigid>(constraint.kind)) {
      add(translated_together(layout, part.nodes, part.displacement, c));
    } else if (std::holds_alternative<Periodic>(constraint.kind)) {
      auto more = periodic_ties(constraints, c, selections);
      if (is_first) add(std::move(more));
    } else if (std::holds_alternative<Equation>(constraint.kind)) {
      auto more = equation_ties(constraints, c, selections);
      if (is_first) add(std::move(more));
    } else if (!part.is_prescribed) {
      add(ties_along(layout, part.nodes, part.direction, c));
    }
  }
  return result;
}

}  // namespace

std::string title_of_constraint(const Config& config, std::size_t index) {
  const ConstraintConfig& constraint = config.constraints[index];
  return std::holds_alternative<Equation>(constraint.kind) ? fmt::format("the equation constraints[{}]", index)
                                                           : describe(constraint.part);
}

std::vector<double> times_to_compare(const Config& config) {
  const double end = config.time.end;
  return {0.0, 0.3819660113 * end, 0.7320508076 * end, end};
}

ConstraintTies find_ties(const ConstraintsOnMesh& constraints, Selections& selections) {
  const auto& [config, layout, parts] = constraints;
  ConstraintTies ties{single_ties(constraints, selections), {}};
  for (std::size_t c = 0; c < parts.size(); ++c) {
    if (!std::holds_alternative<ConstraintConfig::Tied>(config.constraints[c].kind)) continue;
    if (auto tie = make_tie(config, c, layout, selections)) ties.of_surfaces.push_back(std::move(*tie));
  }
  selections.throw_if_errors();
  ties.single = gathered(layout.comm, ties.single);
  return ties;
}

void check_rotating_parts(const ConstraintsOnMesh& constraints, const ConstraintTies& ties, Selections& selections) {
  const auto& [config, layout, parts] = constraints;
  std::map<PetscInt, std::size_t> rotating;  // by the node's global number
  std::set<std::pair<std::size_t, std::size_t>> conflicts;
  for (std::size_t c = 0; c < parts.size(); ++c) {
    if (!parts[c].rotation) continue;
    std::vector<PetscInt> mine;
    for (const PetscInt n : parts[c].nodes) mine.push_back(layout.global_node(n));
    for (const PetscInt node : gathered(layout.comm, mine)) {
      const auto [first, is_new] = rotating.try_emplace(node, c);
      if (!is_new) conflicts.emplace(c, first->second);
    }
  }
  const auto compare = [&](PetscInt node, std::size_t other) {
    const auto found = rotating.find(node);
    if (found != rotating.end()) conflicts.emplace(other, found->second);
  };
  for (const auto& tie : ties.single) {
    for (const auto& e : tie.entries) compare(e.entry / 3, tie.source);
  }
  for (const auto& tie : ties.of_surfaces) {
    for (const PetscInt node : nodes_of(tie)) compare(node, tie.source);
  }
  for (std::size_t c = 0; c < parts.size(); ++c) {
    if (!parts[c].is_prescribed) continue;
    for (const PetscInt n : parts[c].nodes) compare(layout.global_node(n), c);
  }
  // Each rank has compared its own nodes.
  std::vector<std::array<std::size_t, 2>> mine;
  for (const auto& [other, part] : conflicts) mine.push_back({other, part});
  for (const auto& [other, part] : gathered(layout.comm, mine)) conflicts.emplace(other, part);
  for (std::size_t c = 0; c < parts.size() && analysis_of(config) == Analysis::dynamic; ++c) {
    const auto& rigid = parts[c].displacement.rigid;
    const bool is_given = rigid && std::ranges::any_of(rigid->translation, [](const auto& u) { return u.has_value(); });
    if (parts[c].rotation != FreeRotation::about_all_axes || !is_given) continue;
    if (!centre_is_off_plane(layout, parts[c].nodes, *rigid)) continue;
    selections.report(config.constraints[c].where,
                      fmt::format("{} lies in a plane that does not hold its `center`, whose translation is given; in "
                                  "dynamics put `center` into the plane, or choose nodes that span a volume",
                                  title_of_constraint(config, c)));
  }
  for (const auto& [other, part] : conflicts) {
    const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&config.constraints[part].kind);
    if (rigid != nullptr && rigid->is_implied) {
      const std::string title = title_of_constraint(config, other), body = title_of_constraint(config, part);
      const std::string shared =
          title == body
              ? " is a rigid body"
              : fmt::format(" shares nodes with {}{}", body,
                            rigid->attached.empty() ? ", which is a rigid body" : " or with what is attached to it");
      selections.report(
          config.constraints[other].where,
          fmt::format("{}{}: hold or move the rigid body as a whole, by a constraint `rigid` on its volume, or by a "
                      "joint",
                      title, shared));
      continue;
    }
    selections.report(config.constraints[part].where,
                      fmt::format("{} turns freely, so nodes of it cannot obey {} too; give its rotation, or leave out "
                                  "the nodes that both hold",
                                  title_of_constraint(config, part), title_of_constraint(config, other)));
  }
  selections.throw_if_errors();
}

std::vector<Slave> eliminate_ties(const ConstraintsOnMesh& constraints, const PrescribedDisplacement& prescribed,
                                  ConstraintTies ties, Selections& selections) {
  const auto& [config, layout, parts] = constraints;
  std::set<PetscInt> named;
  for (const auto& tie : ties.single) {
    for (const auto& e : tie.entries) named.insert(e.entry);
  }
  for (const auto& tie : ties.of_surfaces) {
    for (const PetscInt node : nodes_of(tie)) named.insert({3 * node, 3 * node + 1, 3 * node + 2});
  }
  auto all = gathered(layout.comm, prescribed.constraints(layout, named));
  const std::size_t num_prescribed = all.size();
  // The reactions of constraints that repeat one another depend on the order, which must not depend on the ranks.
  std::ranges::stable_sort(ties.single, {}, [](const LinearConstraint& tie) {
    return std::pair(tie.source, tie.given.empty() ? Vector3<double>{} : tie.given.front().X);
  });
  std::ranges::move(ties.single, std::back_inserter(all));
  std::vector<GivenDisplacement> given;
  for (const ConstraintPart& part : parts) given.push_back(part.displacement);
  const std::vector<double> times = times_to_compare(config);
  Eliminator eliminator(given, times);
  for (const LinearConstraint& constraint : all) eliminator.add(constraint);
  for (const SurfaceTie& tie : ties.of_surfaces) add_tie(eliminator, tie);
  Elimination result = std::move(eliminator).take();
  for (const auto& [i, j] : result.conflicts) {
    selections.report(config.constraints[j].where,
                      fmt::format("{} and {} contradict each other where they meet; make a component `free`, or let "
                                  "them agree at all times",
                                  title_of_constraint(config, i), title_of_constraint(config, j)));
  }
  selections.throw_if_errors();
  // The first are the prescribed entries themselves.
  result.slaves.erase(result.slaves.begin(), result.slaves.begin() + static_cast<std::ptrdiff_t>(num_prescribed));
  return result.slaves;
}

}  // namespace pliant
