/// The terms of the input's loads and cavities.
#pragma once

#include "energy/term.hpp"
#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"
#include "input/config.hpp"
#include "model/cavities.hpp"
#include "model/selections.hpp"

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

/// The terms of loads and cavities.
class Loads {
 public:
  /// Mistakes are reported to `selections`; if there are any, the object is of no use. Collective.
  Loads(const Config& config, const LoadedBodies& bodies, Selections& selections);

  /// Adds those that depend on what constraints hold. Throws InputError where a cavity is open. Collective.
  void complete(const Config& config, const PrescribedDisplacement& prescribed);

  /// Throws InputError at a load that is not finite at the time [s]. Collective.
  void require_finite(double time) const;

  const std::vector<std::unique_ptr<EnergyTerm>>& terms() const { return terms_; }
  const std::vector<ModelCavity>& cavities() const { return wetted_.cavities(); }

 private:
  void add(std::unique_ptr<EnergyTerm> term, const Location& where);

  const NodeLayout& layout_;
  const BlockPattern& pattern_;
  WettedParts wetted_;
  std::vector<std::unique_ptr<EnergyTerm>> terms_;
  std::vector<Location> places_;  // of the terms in the input
};

}  // namespace pliant
