/// The terms of the input's loads.
#pragma once

#include "app/config.hpp"
#include "app/selections.hpp"
#include "energy/term.hpp"
#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"

#include <memory>
#include <vector>

namespace pliant {

/// What loads act on; outlives their terms.
struct LoadedBodies {
  const NodeLayout& layout;
  const BlockPattern& pattern;
  const std::vector<int>& body_of_cell;  ///< per local cell
  const std::vector<double>& densities;  ///< per body [kg/m^3]
};

/// Whether any load has a dashpot, which needs motion.
bool has_dashpots(const Config& config);

/// A term per load, in the input's order; mistakes are reported to `selections`, and their terms are of no use.
/// Collective.
std::vector<std::unique_ptr<EnergyTerm>> make_loads(const Config& config, const LoadedBodies& bodies,
                                                    Selections& selections);

/// Throws InputError where a force is not finite at the start. `loads`: those of make_loads. Collective.
void check_finite(const std::vector<std::unique_ptr<EnergyTerm>>& loads, const Config& config,
                  const NodeLayout& layout);

}  // namespace pliant
