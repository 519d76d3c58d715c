#include "solver/objective.hpp"

#include "base/stopwatch.hpp"

namespace pliant {

Objective::Objective(StageEquation& equation, SolverStatistics& statistics)
    : equation_(equation),
      statistics_(statistics),
      r_(equation),
      before_(equation),
      diagonal_(equation),
      merit_([&equation] { return equation.make_vector(); }) {}

void Objective::begin_stage(const StagePoint& stage) {
  start_ = stage.q0;
  usual_aim_ = aim_ = equation_.is_potential() ? Aim::minimum : Aim::root;
  is_static_ = equation_.is_static();
  merit_has_scale_ = false;
}

double Objective::value(Vec q) {
  const Stopwatch watch(statistics_.assembly_seconds);
  return equation_.value(q) + proximal_.value(q);
}

void Objective::gradient(Vec q, Vec r) {
  const Stopwatch watch(statistics_.assembly_seconds);
  equation_.gradient(q, r);
  proximal_.add_gradient(q, r);
}

void Objective::hessian(Vec q, Mat K, Projection projection) {
  equation_.hessian(q, K, projection);
  proximal_.add_hessian(K);
}

double Objective::measure(Vec q) {
  if (is_minimised()) return value(q);
  gradient(q, r_.get());
  return merit_.of_residual(r_.get());
}

void Objective::scale_merit(Mat K) {
  if (is_minimised() || merit_has_scale_) return;
  equation_.size_of_diagonal(K, diagonal_.get());
  merit_.set_scale(diagonal_.get());
  merit_has_scale_ = true;
}

void Objective::move(Vec q, Vec to) {
  if (is_static_ || aim_ == Aim::whole_steps) {
    check(VecCopy(q, before_.get()));
    equation_.extrapolate_from(before_.get());
  }
  check(VecCopy(to, q));
}

}  // namespace pliant
