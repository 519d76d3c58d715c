/// The terms of the bodies' viscosity.
#pragma once

#include "energy/volume/expansion.hpp"
#include "fem/cells.hpp"
#include "fem/layout.hpp"
#include "input/config.hpp"
#include "material/law_field.hpp"

#include <memory>
#include <variant>
#include <vector>

namespace pliant {

/// What the terms are built on; must outlive them.
struct BodyParts {
  const NodeLayout& layout;
  const BlockPattern& pattern;
  const std::variant<CellGroups<1>, CellGroups<2>>& cells;
  const std::vector<std::shared_ptr<const LawField>>& elastic;          ///< per body, what viscosity follows
  const std::vector<std::shared_ptr<const FreeExpansion>>& expansions;  ///< per body; nullptr: none
};

/// Whether any body has a viscosity.
bool has_viscosity(const Config& config);

/// The terms for the method of `config`, on which the form of strain rates may depend; none for a static equilibrium.
std::vector<std::unique_ptr<EnergyTerm>> make_viscous_terms(const Config& config, const BodyParts& on);

}  // namespace pliant
