/// The shells of the input on a mesh: thin layers on surfaces.
#pragma once

#include "energy/shell/membrane.hpp"
#include "energy/shell/shell_bending.hpp"
#include "energy/shell/shell_bending_viscosity.hpp"
#include "fem/probe.hpp"
#include "input/config.hpp"
#include "mesh/mesh.hpp"
#include "model/selections.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A layer on the mesh.
struct ModelShell {
  std::string name;
  FacetList facets;
  std::vector<ClampedEdges> clamped;
  double mass_per_area = 0.0;                                ///< [kg/m^2]
  double area = 0.0;                                         ///< of the facets on all ranks [m^2]
  PetscInt64 num_facets = 0;                                 ///< likewise
  MembraneTerms membrane;                                    ///< build_shells
  std::unique_ptr<ShellBending> bending;                     ///< likewise; nullptr: none
  std::unique_ptr<ShellBendingViscosity> bending_viscosity;  ///< likewise
};

/// What resists rates of strain in a layer.
LayerViscosity viscosity_of(const ShellConfig& config);
/// Whether any shell is a body of its own.
bool has_free_shells(const Config& config);
/// Adds free shells to the bodies, after the others.
void add_bodies_of_shells(Config& config);
/// How thick a shell is where it is put on, stretched [m].
double thickness_at_start(const ShellConfig& config);
/// What free shells add to the mesh.
std::vector<AddedShell> added_shells(const Config& config);
/// One flag per local cell: whether it is one of a free shell; empty if none is.
std::vector<char> cells_of_free_shells(const Config& config, const std::vector<int>& body_of_cell);

/// Points in cells of free shells, onto the triangles of these. Not collective.
void move_to_triangles(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                       std::span<ProbeLocation> locations);

struct ModelShells {
  std::vector<ModelShell> shells;

  std::vector<const EnergyTerm*> terms(bool has_velocity) const {
    std::vector<const EnergyTerm*> result;
    for (const ModelShell& shell : shells) {
      result.push_back(shell.membrane.elasticity.get());
      if (shell.membrane.viscosity && has_velocity) result.push_back(shell.membrane.viscosity.get());
      if (shell.bending) result.push_back(shell.bending.get());
      if (shell.bending_viscosity && has_velocity) result.push_back(shell.bending_viscosity.get());
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
