#include "solver/proximal.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>

namespace pliant {

void Proximal::hold(Vec q, PetscInt number, double weight) {
  if (!centre_) {
    check(VecDuplicate(q, centre_.out()));
    check(VecDuplicate(q, weights_.out()));
    check(VecDuplicate(q, force_.out()));
  }
  check(VecCopy(q, centre_.get()));
  check(VecSet(weights_.get(), 0.0));
  const ArrayView weights(weights_.get());
  std::ranges::fill(weights.span().first(static_cast<std::size_t>(number)), weight);
  weight_ = weight;
}

void Proximal::compute_force(Vec q) {
  check(VecWAXPY(force_.get(), -1.0, centre_.get(), q));
  check(VecPointwiseMult(force_.get(), force_.get(), weights_.get()));
}

double Proximal::value(Vec q) {
  if (weight_ == 0.0) return 0.0;
  compute_force(q);
  PetscReal size = 0.0;
  check(VecNorm(force_.get(), NORM_2, &size));
  return 0.5 * size * size / weight_;
}

void Proximal::add_gradient(Vec q, Vec r) {
  if (weight_ == 0.0) return;
  compute_force(q);
  check(VecAXPY(r, 1.0, force_.get()));
}

void Proximal::add_hessian(Mat K) const {
  if (weight_ != 0.0) check(MatDiagonalSet(K, weights_.get(), ADD_VALUES));
}

}  // namespace pliant
