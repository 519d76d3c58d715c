#include "model/tied_surfaces.hpp"

#include "model/touching_surfaces.hpp"
#include "petsc/collective.hpp"

#include <fmt/format.h>

namespace pliant {
namespace {

using Tied = ConstraintConfig::Tied;

/// A gap that is rounding of the mesh's coordinates, relative to the tolerance.
constexpr double no_gap = 1e-6;

std::string counted(std::size_t number) {
  return fmt::format("{} node{}", number, number == 1 ? "" : "s");
}

/// What keeps a tie without tied nodes from tying any.
std::string reason_for_none(const SurfaceTie& tie, const Selection& dependent, const Selection& partner) {
  if (tie.num_free == 0) {
    return fmt::format("{} has all its nodes in common with {}: the mesh joins them already; leave out this constraint",
                       describe(dependent), describe(partner));
  }
  const auto& [x, y, z] = tie.nearest_free;
  return fmt::format(
      "no node of {} lies within {:.3g} m of {}; the nearest one, at ({:.4g}, {:.4g}, {:.4g}), is {:.3g} "
      "m away; move the bodies together, or give a larger `tolerance`",
      describe(dependent), tie.tolerance, describe(partner), x, y, z, tie.least_distance);
}

}  // namespace

std::optional<SurfaceTie> make_tie(const Config& config, std::size_t index, const NodeLayout& layout,
                                   Selections& selections) {
  using Kind = Selection::Kind;
  const ConstraintConfig& constraint = config.constraints[index];
  const auto& tied = std::get<Tied>(constraint.kind);
  const Selection& part = constraint.part;
  if (part.kind != Kind::surface && part.kind != Kind::box && part.kind != Kind::where) {
    selections.report(part.where, fmt::format("{} has no facets that could be tied; choose a part of the surface by "
                                              "`surface`, `box` or `where`",
                                              describe(part)));
    return std::nullopt;
  }
  if (part.kind == Kind::surface && part.name == tied.partner.name) {
    selections.report(tied.partner.where,
                      fmt::format("{} cannot be tied to itself; name another surface", describe(part)));
    return std::nullopt;
  }
  const std::string reason = "where the mesh joins what it separates";
  const FacetList dependent = selections.outer_facets(part, part.where, reason);
  const FacetList independent = selections.outer_facets(tied.partner, tied.partner.where, reason);
  const auto is_missing = [&](const FacetList& facets) {
    return sum(layout.comm, static_cast<PetscInt64>(facets.size())) == 0 ||
           any_rank(layout.comm, std::ranges::find(facets.is_outer, 0) != facets.is_outer.end());
  };
  if (is_missing(dependent) || is_missing(independent)) return std::nullopt;  // already an error
  const CellOfFacets cell_of(layout, independent, {});
  std::vector<PetscInt> cells;
  for (PetscInt f = 0; f < independent.size(); ++f) {
    const auto nodes = std::span(independent.nodes).subspan(f * independent.nodes_per_facet, 3);
    cells.push_back(cell_of(nodes).value_or(-1));
  }
  SurfaceTie tie = tie_surfaces(layout, dependent, {independent, cells}, tied.tolerance, index);
  if (tie.num_tied() > 0) return tie;
  selections.report(constraint.where, reason_for_none(tie, part, tied.partner));
  return std::nullopt;
}

std::vector<PetscInt> owned_nodes(const NodeLayout& layout, const SurfaceTie& tie) {
  std::vector<PetscInt> result;
  for (const TiedNode& tied : tie.nodes) {
    const PetscInt n = tied.node - layout.first_global_node;
    if (!tied.is_shared && n >= 0 && n < layout.num_owned_nodes) result.push_back(n);
  }
  return result;
}

Diagnostic note_of(const Config& config, const SurfaceTie& tie) {
  const ConstraintConfig& constraint = config.constraints[tie.source];
  std::string text = fmt::format("{} of {} {} tied to {}", counted(tie.num_tied()), describe(constraint.part),
                                 tie.num_tied() == 1 ? "is" : "are", describe(std::get<Tied>(constraint.kind).partner));
  if (tie.largest_gap > no_gap * tie.tolerance) text += fmt::format(", over gaps of up to {:.3g} m", tie.largest_gap);
  if (tie.num_free > 0) {
    text += fmt::format("; {} farther away than the tolerance of {:.3g} m {} free, the nearest by {:.3g} m",
                        counted(tie.num_free), tie.tolerance, tie.num_free == 1 ? "stays" : "stay", tie.least_distance);
  }
  if (tie.num_shared > 0) text += fmt::format("; {} in common are left out", counted(tie.num_shared));
  return note(text);
}

std::vector<std::array<Selection, 2>> tied_surfaces(const Config& config) {
  std::vector<std::array<Selection, 2>> result;
  for (const ConstraintConfig& constraint : config.constraints) {
    if (const auto* tied = std::get_if<Tied>(&constraint.kind)) result.push_back({constraint.part, tied->partner});
  }
  return result;
}

}  // namespace pliant
