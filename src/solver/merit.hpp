/// Merit functions: the distance of a stage without a potential from its solution, which its line search lowers.
#pragma once

#include "petsc/handle.hpp"
#include "petsc/work_vector.hpp"

namespace pliant {

/// Euclidean norm. Collective.
double norm(Vec x);
/// Collective.
double dot(Vec a, Vec b);

/// Two measures of a point's distance from r = 0, both energies [J] whatever the unknowns are (metres, radians); D is
/// the absolute diagonal of a Hessian [N/m].
class Merit {
 public:
  /// D = 1 until `set_scale`. `make`: makes a vector of the unknowns, for this object's storage.
  explicit Merit(std::function<Handle<Vec>()> make);

  /// Takes D from the diagonal of K; zero entries are replaced by the mean. Collective.
  void set_scale(Vec diagonal);
  /// D = 1 again. Collective.
  void forget_scale();

  /// 1/2 r . D^-1 r of a residual [N]; +inf if it is not finite. Collective.
  double of_residual(Vec r) const;
  /// 1/2 d . D d of a step [m]; +inf if it is not finite. Collective.
  double of_step(Vec d) const;

 private:
  WorkVector scale_;  // D
};

}  // namespace pliant
