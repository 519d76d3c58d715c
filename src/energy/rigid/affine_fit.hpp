/// The affine motion that is nearest to the motion of some nodes.
#pragma once

#include "base/vector3.hpp"
#include "fem/layout.hpp"

#include <span>
#include <vector>

namespace pliant {

/// u(X) = translation + gradient (X - centre); u: displacements or velocities.
struct AffineMotion {
  Vector3<double> translation{};
  Tensor3<double> gradient{};
};

/// Fits affine motions to nodal vectors by least squares, all nodes weighing the same. Linear in what it fits, so that
/// it commutes with the formulas of the time layer. For nodes in a plane the gradient across it is zero.
class AffineFit {
 public:
  /// `nodes`: owned ones, which span a plane at least. Collective.
  AffineFit(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre);
  /// The same with rotations about an axis (of unit length) and stretches across it alone: sums of such rotations are
  /// of that form. The nodes may lie on a line, if that is not parallel to the axis. Collective.
  AffineFit(const NodeLayout& layout, std::span<const PetscInt> nodes, const Vector3<double>& centre,
            const Vector3<double>& axis);

  /// The motion that is nearest to u on the nodes. Collective.
  AffineMotion operator()(const NodeLayout& layout, std::span<const PetscInt> nodes, Vec u) const;

  /// The mean of the nodes, from the centre [m].
  const Vector3<double>& mean_arm() const { return mean_arm_; }
  /// sum r r^T, r from the mean of the nodes [m^2].
  const Tensor3<double>& second_moment() const { return second_moment_; }
  /// The projector onto the plane of the nodes, or the identity.
  const Tensor3<double>& in_plane() const { return in_plane_; }

 private:
  double number_ = 0.0;
  Vector3<double> centre_;
  Vector3<double> mean_arm_{};
  Tensor3<double> second_moment_{};
  Tensor3<double> inverse_{};  // of the second moment, on the plane
  Tensor3<double> in_plane_ = identity<double>();
  // About an axis: the projector across it, and the turn by a right angle.
  bool has_axis_ = false;
  Tensor3<double> across_{}, turn_{};
};

}  // namespace pliant
