/// The tendons of the input on a mesh.
#pragma once

#include "energy/load/tendon.hpp"
#include "energy/load/tendon_friction.hpp"
#include "input/config.hpp"
#include "mesh/mesh.hpp"
#include "model/attached_points.hpp"
#include "model/selections.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

struct ModelTendon {
  std::string name;
  std::vector<AttachedPoint> points;
  TendonDrive drive;
  std::unique_ptr<Tendon> term;
  std::unique_ptr<TendonFriction> friction;  ///< nullptr: none
  double length = 0.0;                       ///< in the mesh as it is given [m]
  double turn = 0.0;                         ///< sum of the angles between segments there [rad]
};

/// Names or numbers of the physical curves that tendons follow.
std::vector<std::string> curves_of_tendons(const Config& config);

/// The lengthening of a tendon at displacements u of the local nodes [m]: ModelTendon::length is without it.
/// Collective.
double lengthening_of(const ModelTendon& tendon, const NodeLayout& layout, std::span<const double> u);

/// The tension of each segment [N], by friction that at displacements u and velocities v of the local nodes.
/// Collective.
std::vector<double> tensions_of(const ModelTendon& tendon, const NodeLayout& layout, std::span<const double> u,
                                std::span<const double> v, const Instant& at);

/// Throws InputError at tendons with a point outside the mesh, or a curve that is not one line. Collective.
std::vector<ModelTendon> make_tendons(const BodiesOnMesh& bodies, const Mesh& mesh, Selections& selections);

}  // namespace pliant
