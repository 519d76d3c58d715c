/// The shells of the input on a mesh: thin layers on surfaces.
#pragma once

#include "energy/shell/membrane.hpp"
#include "energy/shell/shell_bending.hpp"
#include "input/config.hpp"
#include "model/selections.hpp"

#include <memory>
#include <string>
#include <vector>

namespace pliant {

/// A layer on the mesh.
struct ModelShell {
  std::string name;
  FacetList facets;
  double mass_per_area = 0.0;             ///< [kg/m^2]
  double area = 0.0;                      ///< of the facets on all ranks [m^2]
  PetscInt64 num_facets = 0;              ///< likewise
  MembraneTerms membrane;                 ///< build_shells
  std::unique_ptr<ShellBending> bending;  ///< likewise; nullptr: none
};

struct ModelShells {
  std::vector<ModelShell> shells;

  std::vector<const EnergyTerm*> terms(bool has_velocity) const {
    std::vector<const EnergyTerm*> result;
    for (const ModelShell& shell : shells) {
      result.push_back(shell.membrane.elasticity.get());
      if (shell.membrane.viscosity && has_velocity) result.push_back(shell.membrane.viscosity.get());
      if (shell.bending) result.push_back(shell.bending.get());
    }
    return result;
  }
};

/// Their facets; errors are reported to `selections`. Collective.
ModelShells find_shells(const Config& config, const NodeLayout& layout, Selections& selections);

/// Makes their terms. Throws InputError. Collective.
void build_shells(const Config& config, const NodeLayout& layout, const BlockPattern& pattern, ModelShells& shells);

/// Adds their masses. Not collective.
void add_masses_of_shells(const NodeLayout& layout, const BlockPattern& pattern, MassKind kind,
                          const ModelShells& shells, MassMatrix& mass);

}  // namespace pliant
