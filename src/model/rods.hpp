/// The rods of the input on a mesh.
#pragma once

#include "energy/rod/fibres.hpp"
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
  std::size_t first_segment = 0;      ///< number among the segments of all rods, those of fibres after all others
  bool is_fibre = false;              ///< resists nothing but stretch, and has no cells
  double length = 0.0;                ///< at the start [m]
  int body = 0;                       ///< number among the bodies of the completed input

  std::size_t num_segments() const { return points.size() - 1; }
};

struct ModelRods {
  std::vector<ModelRod> rods;
  std::unique_ptr<Rods> term;        ///< of all but fibres; nullptr: there are none
  std::unique_ptr<Fibres> fibres;    ///< nullptr: there are none
  std::unique_ptr<EnergyTerm> bond;  ///< add_bond (model/rod_bond.hpp); nullptr: none
  std::vector<std::unique_ptr<EnergyTerm>> viscosity;
  std::vector<double> lengths;  ///< of all segments at rest; 0 of sections at ends [m]

  /// Segments of `term`, whose numbers come before those of fibres.
  std::size_t num_bent() const { return term ? term->num_segments() : 0; }
  /// The segment of each local cell, -1: none; empty if there are none but fibres.
  std::span<const std::ptrdiff_t> segment_of_cell() const {
    return term ? std::span<const std::ptrdiff_t>(term->segment_of_cell()) : std::span<const std::ptrdiff_t>();
  }
  std::vector<const EnergyTerm*> terms(bool has_velocity) const;
  /// Adds their mass. Not collective.
  void add_masses(const BlockPattern& pattern, MassKind kind, MassMatrix& mass) const;
  /// What uniform accelerations act on, of this rank's nodes; `of_segments`: one flag per segment. Not collective.
  std::vector<MassAtNode> masses(std::span<const char> of_segments) const;
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

/// Where the input asks for fields of rods that are fibres, which have no cells and no moments: what becomes of them.
std::vector<Diagnostic> notes_about_fibres(const Config& config, const ModelRods& rods);

/// The axial force of all segments at displacements u of the local nodes, the same on every rank [N]. Collective.
std::vector<double> tensions_of(const ModelRods& rods, MPI_Comm comm, std::span<const double> u);
}  // namespace pliant
