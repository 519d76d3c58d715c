/// A potential in addition to a stage's own, which holds the unknowns near a point.
#pragma once

#include "petsc/handle.hpp"

namespace pliant {

/// The proximal term weight / 2 |u - u_0|^2 of the first unknowns on each rank, the displacements. A sequence of
/// minima, each held near the previous one with a smaller weight, descends along a valley of the potential, however
/// curved, to a minimum of the potential itself (proximal point algorithm: Rockafellar 1976, Monotone operators and the
/// proximal point algorithm; with masses as weights, pseudo-transient continuation: Kelley & Keyes 1998, Convergence
/// analysis of pseudo-transient continuation). Collective.
class Proximal {
 public:
  /// Holds the first `number` unknowns of this rank near q, with a weight above zero [N/m].
  void hold(Vec q, PetscInt number, double weight);
  void release() { weight_ = 0.0; }
  /// The point u_0; nullptr before the first `hold`.
  Vec centre() const { return centre_.get(); }

  double value(Vec q);
  void add_gradient(Vec q, Vec r);
  void add_hessian(Mat K) const;

 private:
  /// force_ = weight (q - u_0).
  void compute_force(Vec q);

  double weight_ = 0.0;
  Handle<Vec> centre_, weights_, force_;
};

}  // namespace pliant
