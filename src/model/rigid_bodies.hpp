/// Rigid bodies of the input on a mesh: what they add to it, their masses, and what is implied by them.
#pragma once

#include "energy/volume/affine_bodies.hpp"
#include "fem/components.hpp"
#include "input/config.hpp"
#include "mesh/mesh.hpp"
#include "model/selections.hpp"
#include "model/shells.hpp"

#include <string>
#include <vector>

namespace pliant {

/// The input with each entry of `rods` and `rigid_bodies` among the bodies, in this order after the others, and with
/// the constraint that makes a body rigid where the input has none for it; one that the input has for an entry of
/// `rigid_bodies` has its center. Those of `rigid_bodies` have no density:
/// their masses are given.
Config with_rigid_bodies(Config config);

/// One for each entry of `rigid_bodies` without a surface: about as large as the body.
std::vector<AddedTetrahedron> added_tetrahedra(const Config& config);
/// One for each with a surface.
std::vector<AddedVolume> added_volumes(const Config& config);

/// The masses of `rigid_bodies`, by their numbers among the bodies of the completed input.
std::vector<AffineBody> masses_of_rigid_bodies(const Config& config);

/// What a rigid body weighs, 0 without a density [kg], and its centre of mass at the start, or that of its volume [m].
struct RigidMass {
  double mass = 0.0;
  Vector3<double> center{};
};
/// That of a rigid body of the completed input, with a mesh or without; with the layers
/// on facets all of whose nodes are its own. Collective.
RigidMass mass_of_rigid_body(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                             const ModelShells& shells, int body);

/// `config` of the following: completed by with_rigid_bodies.

/// One flag per component: whether it stands for a body without a mesh, which has no surface. Collective.
std::vector<char> components_of_rigid_bodies(const Config& config, const NodeLayout& layout,
                                             const Components& components, const std::vector<int>& body_of_cell);

/// Whether cells of a body of the completed input are tetrahedra in its place: those of rods, too.
bool stands_for_body(const Config& config, int body);
/// One flag per local cell: whether it stands for a body without a mesh.
std::vector<char> cells_without_mesh(const Config& config, const std::vector<int>& body_of_cell);
/// The same without rods that do not follow a curve of the mesh: places of the input may be in them.
std::vector<char> cells_without_places(const Config& config, const std::vector<int>& body_of_cell);

/// Sets the velocities at the start that `rigid_bodies`, the last of the bodies, have of their own.
void set_velocities_of_rigid_bodies(const Config& config, const NodeLayout& layout,
                                    const std::vector<int>& body_of_cell, Vec v);

/// Sets the moduli of free shells, and of rigid bodies that of the stiffest other body: the stiffness of their contact
/// follows from these.
void set_moduli_of_rigid_bodies(const Config& config, std::vector<double>& shear_moduli);
/// Only the last of it: rigid bodies get the largest modulus of all others.
void give_rigid_bodies_the_largest_modulus(const Config& config, std::vector<double>& shear_moduli);

/// The surfaces of other bodies whose mean motion a rigid one follows, and all that it holds, attached or coupled.
std::vector<Selection> coupled_surfaces(const BodyConfig& body);
std::vector<Selection> surfaces_held_by(const BodyConfig& body);
/// All of them, each with the volume of its rigid body.
std::vector<std::array<Selection, 2>> attached_surfaces(const Config& config);

/// Names of `rigid_bodies`, of `rods` and their sections that are held, and of all of them.
AddedBodies names_of_rigid_bodies(const Config& config);
std::vector<std::string> names_of_rods(const Config& config);
AddedBodies names_of_added_bodies(const Config& config);

}  // namespace pliant
