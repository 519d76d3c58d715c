/// The rods of the input on a mesh.
#pragma once

#include "energy/rod/rods.hpp"
#include "input/config.hpp"
#include "mesh/mesh.hpp"
#include "model/attached_points.hpp"
#include "model/selections.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// A rod on the mesh.
struct ModelRod {
  std::string name;
  std::vector<AttachedPoint> points;  ///< of its axis, in their order
  std::size_t first_segment = 0;      ///< number among the segments of the term
  double length = 0.0;                ///< at the start [m]
  int body = 0;                       ///< number among the bodies of the completed input

  std::size_t num_segments() const { return points.size() - 1; }
};

struct ModelRods {
  std::vector<ModelRod> rods;
  std::unique_ptr<Rods> term;        ///< of all of them; nullptr: there are none
  std::unique_ptr<EnergyTerm> bond;  ///< add_bond; nullptr: none

  std::unique_ptr<EnergyTerm> viscosity;  ///< nullptr: none

  std::vector<const EnergyTerm*> terms(bool has_velocity) const {
    std::vector<const EnergyTerm*> result;
    if (viscosity && has_velocity) result.push_back(viscosity.get());
    if (term) result.push_back(term.get());
    if (bond) result.push_back(bond.get());
    return result;
  }
};

/// Area [m^2], second moments of area [m^4] and distances of the directors' points from the axis [m]: 1 in the
/// direction of the first director, 2 in that of the second.
struct RodSection {
  double area = 0.0;
  std::array<double, 2> second_moments{};
  double torsion = 0.0;  ///< torsion constant J
  std::array<double, 2> arms{};
};
RodSection section_of(const RodConfig& rod);

/// Adds rods, and their sections that are held, to the bodies, after the others; those on the ground get a constraint.
void add_bodies_of_rods(Config& config);
/// The volumes of sections that a rigid body of this name holds.
std::vector<Selection> sections_held_by(const Config& config, const std::string& body);

std::vector<AddedRod> added_rods(const Config& config);
/// Names or numbers of the physical curves that rods follow.
std::vector<std::string> curves_of_rods(const Config& config);

/// `config`: completed (with_rigid_bodies). Collective.
ModelRods make_rods(const Config& config, const Mesh& mesh, const NodeLayout& layout,
                    const std::vector<int>& body_of_cell, Selections& selections);

/// Rods along curves share nodes with bodies, which does not keep them from turning about their axis. The directors'
/// points of those that lie inside a body are held in it by springs of the stiffness G l, G the body's shear modulus
/// and l the length of the segment: about that of the material around a rod. `shear_moduli`: of each body [Pa].
/// Collective.
void add_bond(const BodiesOnMesh& bodies, std::span<const double> shear_moduli, ModelRods& rods);

/// The axial force of all segments of a rod at displacements u of the local nodes, the same on every rank [N].
/// Collective.
std::vector<double> tensions_of(const ModelRods& rods, const ModelRod& rod, MPI_Comm comm, std::span<const double> u);

}  // namespace pliant
