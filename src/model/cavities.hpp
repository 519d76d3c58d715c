/// Pressures on the walls of cavities and on other surfaces.
#pragma once

#include "energy/constraint/prescribed.hpp"
#include "energy/load/cavity.hpp"
#include "input/config.hpp"
#include "model/selections.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A cavity of the model, for its history. The term belongs to the model's loads.
struct ModelCavity {
  std::string name;
  const Cavity* term = nullptr;
  double volume = 0.0;             ///< in the reference configuration [m^3]
  std::optional<double> enclosed;  ///< what its walls surround with plane lids; none: lids do not follow [m^3]
};

/// A term, and the entry of the input that it comes from.
struct LocatedTerm {
  std::unique_ptr<EnergyTerm> term;
  Location where;
};

/// The facets on which fluids press.
struct WettedParts {
  std::vector<FacetList> of_pressures;  ///< per pressure among the loads
  std::vector<FacetList> of_cavities;
};

/// `is_shell`: whether a local cell is one of a free shell; empty if none is. Errors are reported to `selections`.
/// Collective.
WettedParts find_wetted_parts(const Config& config, const NodeLayout& layout, std::span<const char> is_shell,
                              Selections& selections);

/// Warns of cavities that press on the same facets. Collective.
std::vector<Diagnostic> warnings_about_shared_walls(const Config& config, const NodeLayout& layout,
                                                    const WettedParts& parts);

/// Warns of fluids outside their walls and of given volumes of another order than what the walls surround.
std::vector<Diagnostic> warnings_about_given_volumes(const Config& config, std::span<const ModelCavity> cavities);

/// The terms of the pressures among the loads, then those of the cavities.
struct WettedTerms {
  std::vector<LocatedTerm> terms;
  std::vector<ModelCavity> cavities;
};

/// What the terms are depends on whether constraints hold the rims of the parts. Throws InputError where a cavity is
/// open. Collective.
WettedTerms make_wetted_terms(const Config& config, const NodeLayout& layout, const BlockPattern& pattern,
                              WettedParts parts, const PrescribedDisplacement& prescribed);

}  // namespace pliant
