/// Pressures on the walls of cavities and on other surfaces, as the input describes them.
#pragma once

#include "energy/constraint/prescribed.hpp"
#include "energy/load/cavity.hpp"
#include "input/config.hpp"
#include "model/selections.hpp"

#include <memory>
#include <string>
#include <vector>

namespace pliant {

/// A cavity of the model, for its history. The term belongs to the model's loads.
struct ModelCavity {
  std::string name;
  const Cavity* term = nullptr;
  double volume = 0.0;  ///< in the reference configuration [m^3]
};

/// The facets on which fluids press, found before the constraints are known; what their terms are depends on whether
/// constraints hold the rims.
class WettedParts {
 public:
  /// Mistakes are reported to `selections`. Collective.
  WettedParts(const Config& config, Selections& selections);

  /// The terms of the pressures among the loads, then those of the cavities, with the places that name them in the
  /// input. Throws InputError where a cavity is open. Collective.
  struct Term {
    std::unique_ptr<EnergyTerm> term;
    Location where;
  };
  std::vector<Term> make_terms(const Config& config, const NodeLayout& layout, const BlockPattern& pattern,
                               const PrescribedDisplacement& prescribed);

  const std::vector<ModelCavity>& cavities() const { return cavities_; }

 private:
  std::vector<FacetList> of_pressures_, of_cavities_;
  std::vector<ModelCavity> cavities_;
};

}  // namespace pliant
