#include "solver/failed_stage.hpp"

#include "petsc/array_view.hpp"
#include "petsc/copy_of.hpp"
#include "solver/objective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Number of lengths on either side of the profile: 1, then each shorter by the square root of ten.
constexpr int num_lengths = 10;

/// The displacements in a vector of unknowns, as a vector like `displacements`.
Handle<Vec> part_of_displacements(Vec unknowns, Vec displacements) {
  Handle<Vec> part;
  check(VecDuplicate(displacements, part.out()));
  const ConstArrayView from(unknowns);
  const ArrayView to(part.get());
  std::copy_n(from.span().begin(), to.span().size(), to.span().begin());
  return part;
}

}  // namespace

FailedStage look_along_direction(Objective& objective, Vec q, Vec y) {
  StageEquation& equation = objective.equation();
  const Handle<Vec> r = equation.make_vector();
  FailedStage stage;
  stage.rounding_floor = equation.rounding_floor(q);
  stage.measure = objective.is_minimised() ? FailedStage::Measure::potential : FailedStage::Measure::merit;
  stage.displacement = copy_of(equation.displacements(q));
  Vec u = stage.displacement.get();
  check(VecDuplicate(u, stage.direction.out()));
  check(VecSet(stage.direction.get(), 0.0));
  equation.gradient(q, r.get());
  stage.residual = part_of_displacements(r.get(), u);
  if (y == nullptr) return stage;

  const double size = norm(y);
  if (!std::isfinite(size) || size == 0.0) return stage;
  const Handle<Vec> d = copy_of(y), trial = copy_of(q);
  check(VecScale(d.get(), -1.0));
  if (objective.is_minimised()) stage.slope = dot(r.get(), d.get());
  stage.inversion = equation.max_step(q, d.get());
  check(VecAXPY(trial.get(), 1.0, d.get()));
  check(VecWAXPY(stage.direction.get(), -1.0, u, equation.displacements(trial.get())));
  const double here = objective.measure(q);
  const auto sample = [&](double length) {
    check(VecWAXPY(trial.get(), length, d.get(), q));
    stage.profile.push_back({length, objective.measure(trial.get()) - here});
  };
  for (int k = 0; k < num_lengths; ++k) sample(-std::pow(10.0, -0.5 * k));
  stage.profile.push_back({0.0, 0.0});
  for (int k = num_lengths; k-- > 0;) sample(std::pow(10.0, -0.5 * k));
  return stage;
}

}  // namespace pliant
