/// Which facets of the mesh may touch which others, as the input's `contact.pairs`, `contact.exclude` and ties of
/// surfaces say.
#pragma once

#include "collision/contact_pairs.hpp"
#include "energy/contact/body_surfaces.hpp"
#include "fem/components.hpp"
#include "model/selections.hpp"
#include "model/thin_bodies.hpp"

#include <array>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// The local cell of a facet of the mesh's surface, or of a segment of a rod, found by its corners.
class CellOfFacets {
 public:
  /// `thin`: its segments are added.
  CellOfFacets(const NodeLayout& layout, const FacetList& facets, const ThinBodies& thin);
  /// `nodes`: of a facet; its corners come first. Empty if no cell of this rank has it.
  std::optional<PetscInt> operator()(std::span<const PetscInt> nodes) const;

 private:
  std::map<std::array<PetscInt, 3>, PetscInt> cells_;
};

/// What one entry of `contact.pairs`, or `all`, speaks of.
struct TouchingSurfaces {
  FacetList facets;
  std::vector<FacetSide> sides;                     ///< of each facet; its set is one of `sets`
  ContactSets sets;                                 ///< which may touch
  std::vector<char> may_pass;                       ///< of each two sets, by rows: `contact.exclude` lets them
  std::vector<std::array<bool, 2>> set_is_on_side;  ///< of each set: it is of `surface`, of `with` of the entry; of
                                                    ///< neither is the rest of a body in contact by a penalty
  std::vector<char> set_is_mirror;                  ///< of each set: mark_planes_of_symmetry; empty: none is
  std::vector<char> is_on_first_side;               ///< of each facet: it belongs to `surface` of the entry, or to the
                                                    ///< rest of its body if that is not the body of `with`
  std::vector<PetscInt> nodes_left_out;             ///< a local node of each outer facet that takes no part
  NormalKind law = NormalKind::barrier;
  const ContactPairConfig* config = nullptr;  ///< nullptr: `all`
};

struct LayoutOfBodies {
  const NodeLayout& layout;
  const std::vector<int>& body_of_cell;  ///< per local cell
  const ThinBodies& thin;
};

/// `tied`: surfaces that constraints tie; their facets, and those around their rims, never see each other. What is
/// wrong stands in `selections` afterwards. The config outlives the result. Collective.
std::vector<TouchingSurfaces> find_touching_surfaces(const ContactConfig& config,
                                                     const std::vector<std::array<Selection, 2>>& tied,
                                                     const LayoutOfBodies& bodies, Selections& selections);

/// Gives the facets on planes of symmetry sets of their own, one for each set, whose numbers come after all others: the
/// body continues behind them, so that nothing is pushed out there. These are facets across an axis along which all of
/// their corners are prescribed, and one is free otherwise. `prescribed`: one flag per local entry. Not collective.
void mark_planes_of_symmetry(const NodeLayout& layout, std::span<const char> prescribed, TouchingSurfaces& touching);

/// Notes which facets move with a rigid part: `rigid_part`, its number of each local node, from 1; 0: none. Not
/// collective.
void mark_rigid_parts(std::span<const int> rigid_part, TouchingSurfaces& touching);

/// For each two components whether contact keeps them apart, or the input lets them pass by `contact.exclude`, by rows:
/// all their outer facets may touch each other, or, with a penalty, which knows the whole surfaces, some. Collective.
std::vector<char> components_kept_apart(MPI_Comm comm, const Components& components,
                                        std::span<const TouchingSurfaces> touching);

}  // namespace pliant
