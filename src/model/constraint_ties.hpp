/// The ties among the input's constraints: found on the mesh, checked, and eliminated together.
#pragma once

#include "energy/constraint/prescribed.hpp"
#include "energy/constraint/rigid_part.hpp"
#include "energy/constraint/tied_surfaces.hpp"
#include "input/config.hpp"
#include "model/selections.hpp"

#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// An entry of the input's constraints on the mesh.
struct ConstraintPart {
  std::vector<PetscInt> nodes;     ///< owned
  GivenDisplacement displacement;  ///< what its ties refer to, too
  bool is_prescribed = false;      ///< the components that `displacement` gives
  Vector3<double> direction{};     ///< of the force that holds its first component, if that has one of its own
  std::optional<FreeRotation> rotation = std::nullopt;  ///< of a rigid part, if it is not given
  Location where = {};
};

/// The input's constraints: `parts` has one for each, in their order.
struct ConstraintsOnMesh {
  const Config& config;
  const NodeLayout& layout;
  const std::vector<ConstraintPart>& parts;
};

/// The constraint in a message.
std::string title_of_constraint(const Config& config, std::size_t index);
/// Times at which given displacements are compared: the start, the end, and two that no round period fits.
std::vector<double> times_to_compare(const Config& config);

/// The same on every rank.
struct ConstraintTies {
  std::vector<LinearConstraint> single;
  std::vector<SurfaceTie> of_surfaces;
  bool empty() const { return single.empty() && of_surfaces.empty(); }
};

/// Throws InputError with all errors of `selections`. Collective.
ConstraintTies find_ties(const ConstraintsOnMesh& constraints, Selections& selections);

/// Rigid parts that rotate freely obey no other constraint: throws InputError with an error for each that does.
/// Collective.
void check_rotating_parts(const ConstraintsOnMesh& constraints, const ConstraintTies& ties, Selections& selections);

/// The slaves of all ties. Throws InputError where constraints conflict. Collective.
std::vector<Slave> eliminate_ties(const ConstraintsOnMesh& constraints, const PrescribedDisplacement& prescribed,
                                  ConstraintTies ties, Selections& selections);

}  // namespace pliant
