/// What a rank evaluates of the bending of a thin layer: the angles at edges, and the triangles that these bend.
#pragma once

#include "energy/coupling.hpp"
#include "energy/shell/hinge.hpp"
#include "energy/shell/shell_topology.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// A layer's resistance to bending.
struct BendingStiffness {
  double rigidity = 0.0;  ///< D = E h^3 / (12 (1 - nu^2)) [N m]
  double poissons_ratio = 0.0;
};

/// An edge that carries a moment.
struct BendingHinge {
  std::array<PetscInt, 4> nodes{-1, -1, -1, -1};  ///< local: a, b, c, o; o = -1: mirrored
  Vector3<double> mirror{};
  HingeVectors rest{};  ///< e, u, v in the reference configuration [m]

  /// e, u, v of a field x of the local nodes: of their displacements, the changes of these vectors.
  HingeVectors vectors(std::span<const double> x) const;
  /// e, u, v at displacements q of the local nodes [m].
  HingeVectors at(std::span<const double> q) const;
  HingeMap map() const { return hinge_map(nodes[3] < 0 ? &mirror : nullptr); }
};

/// A triangle with a node of this rank in its patch, and the energy 1/2 sum_ij M_ij d_i d_j in the changes d of the
/// angles of its hinges.
struct BendingStencil {
  static constexpr std::size_t most_hinges = 9, most_nodes = 12;

  std::size_t num_hinges = 0, num_nodes = 0;
  std::array<std::size_t, most_hinges> hinges{};
  std::array<PetscInt, most_nodes> nodes{};                      ///< of the hinges, each once
  std::array<std::array<std::int8_t, 4>, most_hinges> places{};  ///< of the hinges' nodes in `nodes`
  std::array<double, most_hinges * most_hinges> M{};             ///< [N m]
  /// The curvature (xx, yy, 2 xy) by the angles, without a moment about free sides [1/m]; the first axis is along the
  /// side from corner 0 to 1, the second across it in the triangle.
  std::array<std::array<double, 3>, most_hinges> curvature{};
  double area = 0.0;      ///< of the triangle at rest [m^2]
  std::size_t patch = 0;  ///< the triangle among NearPatches::patches
  BendingStiffness stiffness;
  bool is_counted = false;
  bool is_surrounded = false;  ///< by neighbours at all sides
};

struct BendingStencils final : PairFeatures {
  std::vector<BendingHinge> hinges;
  std::vector<BendingStencil> stencils;

  /// Those that a term has been given; empty ones where it has none.
  static const BendingStencils& seen(const NearPatches* near);
};

/// All stencils that have a node of this rank; `stiffness`: of each triangle of the topology, whose numbers are the
/// keys of the patches. Not collective.
std::shared_ptr<const BendingStencils> make_bending_stencils(const ShellTopology& topology,
                                                             std::span<const BendingStiffness> stiffness,
                                                             const NearPatches& near);

}  // namespace pliant
