/// The springs of the input on a mesh.
#pragma once

#include "energy/load/spring.hpp"
#include "model/attached_points.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

struct ModelSprings {
  std::vector<std::string> names;
  std::vector<AttachedPoint> points;  ///< two for each
  std::vector<LineSpring> springs;
  std::vector<std::unique_ptr<EnergyTerm>> terms;  ///< of those that have stiffness, and of those that have damping
};

/// A static equilibrium has no rates, and no dampers. Throws InputError at points outside the mesh and in bodies that
/// are not rigid. Collective.
ModelSprings make_springs(const BodiesOnMesh& bodies);

/// The length [m] and the force [N], positive where it pulls, of each spring at displacements and velocities of the
/// local nodes. Collective.
std::vector<double> states_of(const ModelSprings& springs, const NodeLayout& layout, std::span<const double> u,
                              std::span<const double> v);

}  // namespace pliant
