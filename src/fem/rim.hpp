/// The rim of a surface (its boundary edges), and whether the surface can sweep a volume there.
#pragma once

#include "fem/selection.hpp"

#include <array>
#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace pliant {

/// An edge on which a surface ends, with the surface on its left seen from outside.
struct RimEdge {
  std::array<PetscInt, 3> nodes{};  ///< local: ends, mid-edge node (order 2)
  std::optional<int> plane;         ///< if it stays within a plane of constant x, y or z, whatever the free entries do
  std::array<double, 3> normal{};   ///< of the facet at the edge, of unit length
};

/// What the free entries of the displacement can do to a rim.
enum class Rim {
  none,    ///< the surface is closed
  still,   ///< it is at rest, or slides within planes that are at rest
  moving,  ///< it sweeps a volume, but one that only prescribed entries determine, or on which parts of the rim do not
           ///< interact
  free     ///< the volume that it sweeps depends on the path of the solid
};

/// Prescribed entries and their displacements at some times, per local entry, ghosts included.
struct PrescribedSamples {
  std::span<const char> flags;
  std::vector<std::vector<double>> displacements;  ///< [m]; 0 in free entries
};

/// The edges that belong to one facet only, each on one of the ranks. Facets that meet there with opposite directions
/// count as continuous. Not collective.
std::vector<RimEdge> rim_edges(const NodeLayout& layout, const FacetList& facets);

/// The worst of the edges on all ranks; sets their `plane`. Collective.
///
/// The antisymmetric part of a uniform pressure's tangent is int N_a N_b x' . (da cross db) ds along the rim, for
/// motions da and db of its nodes. It vanishes on an edge if for all free entries i of a node and j of a node, i != j,
/// the edge does not extend in the third direction. Prescribed entries that move count as the j's do: the work of a
/// pressure in a stage is integrated along a path on which they move, too.
Rim classify(const NodeLayout& layout, std::vector<RimEdge>& edges, const PrescribedSamples& prescribed);

/// Middles of the edges of all ranks that are of this kind, in ascending order [m]. Collective.
std::vector<std::array<double, 3>> places_of(Rim kind, const NodeLayout& layout, std::vector<RimEdge> edges,
                                             const PrescribedSamples& prescribed);

/// Whether the planes in which edges slide close the ends of a hollow. They do not where a whole loop slides along
/// walls that lie in these planes, as at the end of a square tube that becomes longer: no lid goes with it. To be
/// called after `classify`. Collective.
bool planes_close(const NodeLayout& layout, const std::vector<RimEdge>& edges);

/// Why the lids of a loop do not follow from it.
struct UnknownLid {
  std::optional<int> direction;    ///< edges slide in two planes of constant x, y or z; nothing: edges that are held,
                                   ///< between some that slide, lie in no plane
  std::array<double, 2> places{};  ///< of the two planes [m]
};

/// The volume behind the surface in the reference configuration [m^3], positive if the facets face into it. Lids close
/// the loops of the rim: plane ones where edges slide in planes, and across edges that are held between these; a cone
/// to its middle where a loop is held all around. Collective.
std::variant<double, UnknownLid> volume_behind(const NodeLayout& layout, const FacetList& facets,
                                               const std::vector<RimEdge>& edges);

}  // namespace pliant
