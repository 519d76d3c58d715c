#include "solver/fixed_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

/// Beyond this number of differences the oldest are dropped.
constexpr std::size_t max_differences = 6;
/// The differences are discarded where the error has grown by this factor, as from one side of a kink to the other, and
/// from there on the steps are shorter by the second.
constexpr double much_larger = 2.0, shorter = 0.5;
/// A difference whose part independent of the others is below this fraction of its square is dropped.
constexpr double dependent = 1e-12;

Handle<Vec> like(Vec x) {
  Handle<Vec> copy;
  check(VecDuplicate(x, copy.out()));
  return copy;
}

double norm_of(Vec x) {
  PetscReal norm = 0.0;
  check(VecNorm(x, NORM_2, &norm));
  return norm;
}

double dot_of(Vec x, Vec y) {
  PetscScalar product = 0.0;
  check(VecDot(x, y, &product));
  return product;
}

}  // namespace

FixedPoint::FixedPoint(Vec x)
    : x_(like(x)), f_(like(x)), g_(like(x)), step_(like(x)), least_(std::numeric_limits<double>::infinity()) {
  check(VecCopy(x, x_.get()));
}

Vec FixedPoint::step(Vec g) {
  Handle<Vec> f = like(g);
  check(VecWAXPY(f.get(), -1.0, x_.get(), g));
  const double size = norm_of(f.get());
  if (size > much_larger * least_) {
    dF_.clear();
    dG_.clear();
    least_ = size;
    mixing_ *= shorter;
  } else if (!is_first_) {
    for (auto& [list, newest, last] : {std::tuple{&dF_, f.get(), f_.get()}, {&dG_, g, g_.get()}}) {
      list->push_back(like(g));
      check(VecWAXPY(list->back().get(), -1.0, last, newest));
      if (list->size() > max_differences) list->erase(list->begin());
    }
  }
  if (is_first_) first_ = size;
  size_ = size;
  least_ = std::min(least_, size);
  is_first_ = false;
  f_ = std::move(f);
  check(VecCopy(g, g_.get()));
  check(VecCopy(f_.get(), step_.get()));
  check(VecScale(step_.get(), mixing_ - 1.0));
  std::vector<double> gamma(dF_.size(), 0.0);
  solve_least_squares(gamma);
  for (std::size_t i = 0; i < gamma.size(); ++i) {
    check(VecAXPBYPCZ(step_.get(), -gamma[i], (1.0 - mixing_) * gamma[i], 1.0, dG_[i].get(), dF_[i].get()));
  }
  return step_.get();
}

void FixedPoint::take(Vec x) {
  check(VecCopy(x, x_.get()));
}

// Gram-Schmidt orthogonalization, newest difference first, so that old ones without new information drop out.
void FixedPoint::solve_least_squares(std::vector<double>& gamma) const {
  const std::size_t n = gamma.size();
  std::vector<Handle<Vec>> basis;
  std::vector<std::vector<double>> R(n, std::vector<double>(n, 0.0));
  std::vector<double> along(n, 0.0);
  std::vector<std::size_t> kept;
  for (std::size_t i = n; i-- > 0;) {
    Handle<Vec> e = like(dF_[i].get());
    check(VecCopy(dF_[i].get(), e.get()));
    const double size = norm_of(e.get());
    for (std::size_t b = 0; b < basis.size(); ++b) {
      R[b][kept.size()] = dot_of(basis[b].get(), e.get());
      check(VecAXPY(e.get(), -R[b][kept.size()], basis[b].get()));
    }
    const double rest = norm_of(e.get());
    if (!(rest > std::sqrt(dependent) * size)) continue;
    check(VecScale(e.get(), 1.0 / rest));
    R[basis.size()][kept.size()] = rest;
    along[basis.size()] = dot_of(e.get(), f_.get());
    basis.push_back(std::move(e));
    kept.push_back(i);
  }
  for (std::size_t j = kept.size(); j-- > 0;) {
    double value = along[j];
    for (std::size_t k = j + 1; k < kept.size(); ++k) value -= R[j][k] * gamma[kept[k]];
    gamma[kept[j]] = value / R[j][j];
  }
}

}  // namespace pliant
