/// The local rotation of the body around each node.
#pragma once

#include "base/several.hpp"
#include "base/vector3.hpp"
#include "fem/layout.hpp"

#include <span>
#include <vector>

namespace pliant {

/// The rotation R_a of the cells around each owned node a, from one configuration to another: the one that best fits
/// the motion of their corners (the polar factor of its moment matrix).
///
/// The stiffness of a body rotates with it. With R the block diagonal matrix of the R_a, K(q) is close to R K(q_start)
/// R^T where strains change little, however far the body rotates ("stiffness warping": Mueller et al. 2002, "Stable
/// real-time deformations"), and the inverse of an old K becomes a corotated preconditioner of the present one. R
/// commutes with mass matrices up to the difference between neighbours' rotations.
class NodalRotations {
 public:
  /// `is_held`: as in `hold`. `layout` outlives the object.
  NodalRotations(const NodeLayout& layout, std::span<const char> is_held);
  /// One flag per owned entry (at least): nodes with such an entry do not rotate.
  void hold(std::span<const char> is_held);

  /// Sets the reference of the rotations to the configuration with the displacement u [m]. Collective.
  void start(Vec u);
  /// Updates the rotations to the configuration of u, which may have rotated by at most a radian since the last call.
  /// Collective.
  void follow(Vec u);
  const Tensor3<double>& operator[](PetscInt owned_node) const { return rotations_[owned_node]; }

  /// x is replaced by R x, and by R^T x. Not collective.
  void turn(Vec x) const;
  void turn_back(Vec x) const;
  /// The same for the owned entries of several vectors at once.
  void turn(std::span<SeveralDoubles> x) const;
  void turn_back(std::span<SeveralDoubles> x) const;

 private:
  /// Positions of local nodes [m].
  void positions_of(Vec u, std::vector<double>& positions);

  const NodeLayout& layout_;
  std::vector<char> turns_;  // of owned nodes
  std::vector<Tensor3<double>> rotations_, moments_;
  std::vector<double> start_, now_;  // xyz of local nodes
  Handle<Vec> with_ghosts_;
};

}  // namespace pliant
