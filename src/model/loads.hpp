/// The terms of the input's loads and cavities.
#pragma once

#include "energy/term.hpp"
#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"
#include "input/config.hpp"
#include "model/cavities.hpp"
#include "model/rods.hpp"
#include "model/selections.hpp"
#include "model/shells.hpp"

#include <memory>
#include <vector>

namespace pliant {

/// What loads act on; must outlive their terms.
struct LoadedBodies {
  const NodeLayout& layout;
  const BlockPattern& pattern;
  const std::vector<int>& body_of_cell;  ///< per local cell
  const std::vector<double>& densities;  ///< per body [kg/m^3]
  const ModelRods& rods;
  const ModelShells& shells;
};

/// Whether any load has a dashpot, which needs motion.
bool has_dashpots(const Config& config);

/// What loads and cavities need of the mesh, found before constraints are known.
struct LoadParts {
  std::vector<LocatedTerm> terms;  ///< of the loads that do not depend on constraints
  WettedParts wetted;
};

/// Errors are reported to `selections`; if there are any, the result is of no use. Collective.
LoadParts find_loads(const Config& config, const LoadedBodies& bodies, Selections& selections);

/// The terms of loads and cavities.
class Loads {
 public:
  /// Throws InputError where a cavity is open. Collective.
  Loads(const Config& config, const NodeLayout& layout, const BlockPattern& pattern, LoadParts parts,
        const PrescribedDisplacement& prescribed);

  /// Throws InputError at a load that is not finite at the time [s]. Collective.
  void require_finite(double time) const;

  const std::vector<LocatedTerm>& terms() const { return terms_; }
  const std::vector<ModelCavity>& cavities() const { return cavities_; }

 private:
  const NodeLayout& layout_;
  std::vector<LocatedTerm> terms_;
  std::vector<ModelCavity> cavities_;
};

}  // namespace pliant
