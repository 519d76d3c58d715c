/// What of the bodies may touch obstacles, and each other.
#pragma once

#include "model/touching_surfaces.hpp"

#include <vector>

namespace pliant {

struct MayTouch {
  ThinBodies thin;
  FacetList obstacles;                       ///< facets and segments that may touch obstacles
  std::vector<TouchingSurfaces> each_other;  ///< of each entry of `contact.pairs`

  /// The shear moduli that contact goes by: `shear_moduli` of the bodies, those of rods, and of rigid bodies that of
  /// the stiffest other one [Pa].
  std::vector<double> moduli(const Config& config, const std::vector<double>& shear_moduli) const;
};

/// `config`: completed, with contact. What is wrong stands in `selections` afterwards. The config outlives the result.
/// Collective.
MayTouch find_what_may_touch(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                             const ModelRods& rods, Selections& selections);

}  // namespace pliant
