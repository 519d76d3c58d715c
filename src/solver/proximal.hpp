/// A potential beside that of a stage, which holds the unknowns near a point.
#pragma once

#include "petsc/handle.hpp"

namespace pliant {

/// weight / 2 |u - u_0|^2 of the first unknowns of each rank, those of displacements. Minima held near the one before,
/// with weights that become small, lead down a valley of the potential, however curved it is, to a minimum of the
/// potential itself (the proximal point algorithm: Rockafellar 1976, Monotone operators and the proximal point
/// algorithm; with masses as weights, pseudo-transient continuation: Kelley & Keyes 1998, Convergence analysis of
/// pseudo-transient continuation). Collective.
class Proximal {
 public:
  /// Holds the first `number` unknowns of this rank near q, with a weight above zero [N/m].
  void hold(Vec q, PetscInt number, double weight);
  void release() { weight_ = 0.0; }
  /// Where it holds them; nullptr before the first time.
  Vec centre() const { return centre_.get(); }

  double value(Vec q);
  void add_gradient(Vec q, Vec r);
  void add_hessian(Mat K) const;

 private:
  void compute_force(Vec q);

  double weight_ = 0.0;
  Handle<Vec> centre_, weights_, force_;
};

}  // namespace pliant
