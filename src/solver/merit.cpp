#include "solver/merit.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace pliant {
namespace {

/// 1/2 sum of term(x_i, D_i) over all ranks.
template <class Term>
double half_sum(Vec x, Vec scale, Term term) {
  double mine = 0.0;
  {
    const ConstArrayView values(x), D(scale);
    for (std::size_t i = 0; i < values.span().size(); ++i) mine += term(values.span()[i], D.span()[i]);
  }
  const double total = sum(PetscObjectComm(reinterpret_cast<PetscObject>(x)), mine);
  return std::isfinite(total) ? 0.5 * total : std::numeric_limits<double>::infinity();
}

}  // namespace

double norm(Vec x) {
  PetscReal result = 0.0;
  check(VecNorm(x, NORM_2, &result));
  return result;
}

double dot(Vec a, Vec b) {
  PetscScalar result = 0.0;
  check(VecDot(a, b, &result));
  return result;
}

Merit::Merit(std::function<Handle<Vec>()> make)
    : scale_([make = std::move(make)] {
        Handle<Vec> ones = make();
        check(VecSet(ones.get(), 1.0));
        return ones;
      }) {}

void Merit::forget_scale() {
  if (scale_.is_used()) check(VecSet(scale_.get(), 1.0));
}

void Merit::set_scale(Vec diagonal) {
  check(VecCopy(diagonal, scale_.get()));
  PetscReal total = 0.0;
  PetscInt size = 0;
  check(VecNorm(scale_.get(), NORM_1, &total));
  check(VecGetSize(scale_.get(), &size));
  const double mean = total > 0.0 ? total / size : 1.0;
  const ArrayView D(scale_.get());
  for (double& d : D.span()) {
    d = std::abs(d);
    if (d <= std::numeric_limits<double>::epsilon() * mean) d = mean;
  }
}

double Merit::of_residual(Vec r) const {
  return half_sum(r, scale_.get(), [](double x, double d) { return x * x / d; });
}

double Merit::of_step(Vec d) const {
  return half_sum(d, scale_.get(), [](double x, double scale) { return x * x * scale; });
}

}  // namespace pliant
