#include "solver/path_solver.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

/// Iterations of a step: those from a predictor that is near the path converge within a few.
constexpr int max_iterations = 15;
/// A residual that has grown so much is that of another place.
constexpr double most_growth = 1e4;
/// The part of the step's length that may be missing at its end.
constexpr double missing_length = 1e-6;
/// Steps that must be cut shorter than this fraction before a tetrahedron inverts lead nowhere.
constexpr double least_fraction = 0.05;
/// Differences over the load factor, as a fraction of it, and of the part of it that the first step adds.
constexpr double load_spacing = 1e-5;
/// Along a tangent, whose length is 1, for the direction in which nodes move.
constexpr double small_length = 1e-5;

constexpr double load_weight = 0.5;

}  // namespace

PathSolver::PathSolver(StageEquation& equation, const NewtonOptions& options, LinearKind linear, PoseStage pose)
    : equation_(equation),
      options_(options),
      pose_(std::move(pose)),
      objective_(equation, statistics_),
      loop_(objective_, options, linear, statistics_),
      system_(objective_, loop_.system(), loop_.linear_solver()) {
  for (Point* x : {&point_, &tangent_, &trial_, &next_tangent_}) *x = make_point();
  for (Handle<Vec>* x : {&entered_, &from_, &r_, &other_r_, &f_, &a_, &b_, &d_}) *x = equation.make_vector();
  for (Handle<Vec>* q : {&accepted_, &q_}) {
    check(VecDuplicate(equation.displacements(entered_.get()), q->out()));
  }
  PetscInt size = 0, num_displacements = 0;
  check(VecGetLocalSize(entered_.get(), &size));
  check(VecGetLocalSize(q_.get(), &num_displacements));
  counts_.assign(static_cast<std::size_t>(size), 0);
  for (PetscInt i = 0; i < std::min(size, num_displacements); ++i) {
    const auto k = static_cast<std::size_t>(i);
    counts_[k] = equation.prescribed()[k] != 0 ? 0 : 1;
  }
}

PathSolver::Point PathSolver::make_point() const {
  return {equation_.make_vector(), 0.0};
}

void PathSolver::assign(const Point& from, Point& to) {
  check(VecCopy(from.xi.get(), to.xi.get()));
  to.load = from.load;
}

double PathSolver::inner(Vec x, Vec y) const {
  double total = 0.0;
  {
    const ConstArrayView a(x), b(y);
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (counts_[i] != 0) total += a.span()[i] * b.span()[i];
    }
  }
  return sum(equation_.comm(), total);
}

void PathSolver::pose(double load, Vec xi) {
  check(VecCopy(accepted_.get(), q_.get()));
  const StagePoint stage = pose_(load, q_.get());
  const StagePoint whole = equation_.enter(stage, q_.get(), entered_.get());
  {
    const ConstArrayView from(entered_.get());
    const ArrayView to(xi);
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (equation_.prescribed()[i] != 0) to.span()[i] = from.span()[i];
    }
  }
  objective_.begin_stage(whole);
  equation_.freeze(xi);
}

void PathSolver::start(Vec q, double load_factor) {
  check(VecCopy(q, accepted_.get()));
  check(VecCopy(q, q_.get()));
  equation_.enter(pose_(load_factor, q_.get()), q_.get(), entered_.get());
  check(VecCopy(entered_.get(), point_.xi.get()));
  point_.load = load_factor;
}

void PathSolver::begin_attempt() {
  ++statistics_.stages;
  ++statistics_.residual_solves;
  loop_.begin_stage();
  failure_.reset();
}

StageReport PathSolver::failed(StageReport report, const char* reason) {
  report.outcome = StageOutcome::retry;
  report.reason = reason;
  if (loop_.system().factor().lacks_memory()) {
    report.outcome = StageOutcome::fatal;
    report.reason = "there is too little memory for the factorization (MUMPS)";
  }
  return report;
}

void PathSolver::load_derivative(const Point& x, Vec f) {
  const double h = load_spacing * std::max(std::abs(x.load), load_unit_);
  for (const double side : {1.0, -1.0}) {
    check(VecCopy(x.xi.get(), d_.get()));
    pose(x.load + side * h, d_.get());
    equation_.gradient(d_.get(), side > 0.0 ? f : other_r_.get());
  }
  check(VecAXPY(f, -1.0, other_r_.get()));
  check(VecScale(f, 0.5 / h));
  pose(x.load, x.xi.get());
}

StageReport PathSolver::find_tangent(const Point& x, Point& tangent) {
  load_derivative(x, f_.get());
  LinearSystem& linear = loop_.system();
  linear.factor().renew();  // its pivots are counted
  const bool works = system_.begin(x.xi.get()) && system_.solve(f_.get(), b_.get());
  unstable_modes_ = works ? linear.unstable_modes() : std::nullopt;
  system_.end();
  const double size = works ? inner(b_.get(), b_.get()) : 0.0;
  if (!works || !std::isfinite(size)) {
    return failed({}, "the tangent stiffness is singular: this is a point at which paths may cross");
  }
  if (scale_ == 0.0) {
    if (!(size > 0.0)) {
      return {StageOutcome::fatal,
              "the load factor moves nothing that is free at the start of the path: give a load or a prescribed motion "
              "that does"};
    }
    scale_ = (1.0 - load_weight) / size;
  }
  check(VecCopy(b_.get(), tangent.xi.get()));
  check(VecScale(tangent.xi.get(), -1.0));
  tangent.load = 1.0;
  return {};
}

double PathSolver::length_of(const Point& direction) const {
  return std::sqrt(scale_ * inner(direction.xi.get(), direction.xi.get()) +
                   load_weight * direction.load * direction.load);
}

void PathSolver::normalize(Point& direction) const {
  const double length = length_of(direction);
  check(VecScale(direction.xi.get(), 1.0 / length));
  direction.load /= length;
}

StageReport PathSolver::settle() {
  begin_attempt();
  assign(point_, trial_);
  pose(trial_.load, trial_.xi.get());
  check(VecCopy(point_.xi.get(), from_.get()));
  const StageReport report = correct(Hold::load, 0.0);
  if (report.outcome == StageOutcome::converged) assign(trial_, point_);
  return report;
}

StageReport PathSolver::aim(Vec earlier_q, double earlier_load_factor) {
  loop_.begin_stage();
  pose(point_.load, point_.xi.get());
  const StageReport report = find_tangent(point_, tangent_);
  if (report.outcome != StageOutcome::converged) return report;
  normalize(tangent_);
  has_tangent_ = true;
  if (earlier_q == nullptr) return report;
  // The unknowns of the earlier point may have meant something else; displacements of nodes do not.
  check(VecCopy(equation_.displacements(point_.xi.get()), q_.get()));
  check(VecWAXPY(d_.get(), small_length, tangent_.xi.get(), point_.xi.get()));
  const Vec moved = equation_.displacements(d_.get());
  double ahead = 0.0;
  {
    const ConstArrayView here(q_.get()), there(moved), before(earlier_q);
    for (std::size_t i = 0; i < here.span().size(); ++i) {
      ahead += (there.span()[i] - here.span()[i]) / small_length * (here.span()[i] - before.span()[i]);
    }
  }
  ahead = scale_ * sum(equation_.comm(), ahead) + load_weight * tangent_.load * (point_.load - earlier_load_factor);
  if (ahead >= 0.0) return report;
  check(VecScale(tangent_.xi.get(), -1.0));
  tangent_.load *= -1.0;
  return report;
}

double PathSolver::advanced() const {
  check(VecWAXPY(d_.get(), -1.0, point_.xi.get(), trial_.xi.get()));
  return scale_ * inner(tangent_.xi.get(), d_.get()) + load_weight * tangent_.load * (trial_.load - point_.load);
}

double PathSolver::move_trial(double change) {
  check(VecCopy(trial_.xi.get(), from_.get()));
  const double load = trial_.load;
  check(VecAXPY(trial_.xi.get(), 1.0, d_.get()));
  pose(load + change, trial_.xi.get());
  check(VecWAXPY(d_.get(), -1.0, from_.get(), trial_.xi.get()));  // with prescribed entries
  const double reach = inversion_margin * equation_.max_step(from_.get(), d_.get());
  trial_.load = load + change;
  if (reach >= 1.0 || !(reach > 0.0)) return reach >= 1.0 ? 1.0 : 0.0;
  ++statistics_.capped_steps;
  trial_.load = load + reach * change;
  check(VecWAXPY(trial_.xi.get(), reach, d_.get(), from_.get()));
  pose(trial_.load, trial_.xi.get());
  return reach;
}

StageReport PathSolver::step(double length) {
  begin_attempt();
  assign(point_, trial_);
  load_unit_ = std::max(std::abs(tangent_.load) * length, load_spacing);
  check(VecCopy(tangent_.xi.get(), d_.get()));
  check(VecScale(d_.get(), length));
  if (move_trial(length * tangent_.load) < 1.0) {
    return failed({}, "a step of this length along the tangent turns a tetrahedron inside out, or crosses a barrier");
  }
  return finish(correct(Hold::arc, length));
}

StageReport PathSolver::land(double load_factor) {
  const PathStep beyond = found_;
  Point end = make_point(), end_tangent = make_point();
  assign(trial_, end);
  assign(next_tangent_, end_tangent);
  const double part = (load_factor - point_.load) / (trial_.load - point_.load);
  check(VecAXPBY(trial_.xi.get(), 1.0 - part, part, point_.xi.get()));
  trial_.load = load_factor;
  pose(load_factor, trial_.xi.get());
  check(VecCopy(point_.xi.get(), from_.get()));
  StageReport report = finish(correct(Hold::load, 0.0));
  if (report.outcome == StageOutcome::converged) return report;
  found_ = beyond;
  assign(end, trial_);
  assign(end_tangent, next_tangent_);
  pose(trial_.load, trial_.xi.get());
  return report;
}

// From the trial point, at whose load factor the equation is posed.
StageReport PathSolver::correct(Hold hold, double length) {
  StageReport report;
  loop_.convergence().measure_guess(trial_.xi.get());
  double first = 0.0;
  IterationLog& log = loop_.log();
  NewtonIteration iteration;
  for (;; ++report.newton_iterations) {
    objective_.gradient(trial_.xi.get(), r_.get());
    iteration.residual = norm(r_.get());
    log.note(iteration, loop_.convergence().target(), report.newton_iterations == 0);
    if (report.newton_iterations == 0) first = iteration.residual;
    using enum Convergence::Verdict;
    const auto verdict =
        loop_.convergence().judge(report.newton_iterations, iteration.residual, trial_.xi.get(), false);
    if (verdict == not_a_number) return failed(report, "the residual is not a number");
    const bool is_there = hold == Hold::load || std::abs(advanced() - length) <= missing_length * length;
    if (verdict != iterating && is_there) {
      if (verdict == at_rounding) loop_.convergence().count_rounding(iteration.residual, trial_.xi.get());
      if (!equation_.refreeze(trial_.xi.get())) break;
      objective_.gradient(trial_.xi.get(), r_.get());
      if (norm(r_.get()) <= loop_.convergence().target()) break;
    }
    if (report.newton_iterations >= std::min(max_iterations, options_.max_iterations)) {
      return failed(report, "Newton's method along the path ran out of iterations");
    }
    if (iteration.residual > most_growth * std::max(first, loop_.convergence().scale())) {
      return failed(report, "Newton's method along the path diverged");
    }
    const long long before = statistics_.linear_iterations;
    if (!improve(hold, length, report)) return report;
    iteration.linear_iterations = static_cast<int>(statistics_.linear_iterations - before);
    iteration.step_length = last_fraction_;
    ++statistics_.newton_iterations;
    report.linear_iterations += iteration.linear_iterations;
  }
  report.reason = "converged";
  return report;
}

bool PathSolver::improve(Hold hold, double length, StageReport& report) {
  const auto fail = [&](const char* reason) {
    report = failed(report, reason);
    return false;
  };
  if (hold == Hold::arc) load_derivative(trial_, f_.get());
  const bool works = system_.begin(trial_.xi.get(), from_.get()) && system_.solve(r_.get(), a_.get()) &&
                     (hold == Hold::load || system_.solve(f_.get(), b_.get()));
  system_.end();
  if (!works) return fail("the linear systems of Newton's method along the path have no solution");
  double change = 0.0;
  if (hold == Hold::arc) {
    const double along_a = scale_ * inner(tangent_.xi.get(), a_.get());
    const double along_b = scale_ * inner(tangent_.xi.get(), b_.get());
    change = (length - advanced() + along_a) / (load_weight * tangent_.load - along_b);
  }
  check(VecCopy(a_.get(), d_.get()));
  check(VecScale(d_.get(), -1.0));
  if (hold == Hold::arc) check(VecAXPY(d_.get(), -change, b_.get()));
  if (!std::isfinite(change) || !std::isfinite(norm(d_.get()))) {
    return fail("the linear systems of Newton's method along the path have no solution");
  }
  last_fraction_ = move_trial(change);
  if (last_fraction_ < least_fraction) {
    return fail("Newton's method along the path would turn a tetrahedron inside out, or cross a barrier");
  }
  return true;
}

// The angle between the tangent at the start and the step follows from <t, x - x_n>; the tangent at the end is turned
// to the side to which the step leads.
StageReport PathSolver::finish(StageReport report) {
  const auto fail = [&] {
    failure_.emplace();
    check(VecDuplicate(trial_.xi.get(), failure_->out()));
    check(VecCopy(trial_.xi.get(), failure_->get()));
    return report;
  };
  if (report.outcome != StageOutcome::converged) return fail();
  const StageReport of_tangent = find_tangent(trial_, next_tangent_);
  if (of_tangent.outcome != StageOutcome::converged) {
    report.outcome = of_tangent.outcome;
    report.reason = of_tangent.reason;
    return fail();
  }
  found_.load_factor = trial_.load;
  found_.length = advanced();  // sets d_
  found_.unstable_modes = unstable_modes_;
  const double change = trial_.load - point_.load;
  const double chord = std::sqrt(scale_ * inner(d_.get(), d_.get()) + load_weight * change * change);
  double ahead = scale_ * inner(next_tangent_.xi.get(), d_.get()) + load_weight * next_tangent_.load * change;
  if (ahead < 0.0) {
    check(VecScale(next_tangent_.xi.get(), -1.0));
    next_tangent_.load *= -1.0;
    ahead *= -1.0;
  }
  const double both =
      scale_ * inner(tangent_.xi.get(), next_tangent_.xi.get()) + load_weight * tangent_.load * next_tangent_.load;
  found_.turn = std::acos(std::clamp(std::min(found_.length, ahead / length_of(next_tangent_)) / chord, -1.0, 1.0));
  found_.slope_at_start = tangent_.load;
  found_.slope_at_end = next_tangent_.load / both;
  return report;
}

void PathSolver::accept(bool keeps_tangent) {
  assign(next_tangent_, tangent_);
  const double size = inner(tangent_.xi.get(), tangent_.xi.get());
  if (size > 0.0) scale_ = std::max(scale_, (1.0 - load_weight) / size);
  normalize(tangent_);
  has_tangent_ = keeps_tangent;
}

std::optional<FailedStage> PathSolver::examine() {
  if (!failure_) return std::nullopt;
  FailedStage stage = look_along_direction(objective_, failure_->get(), nullptr);
  stage.dt = 1.0;
  stage.tolerance = loop_.convergence().target();
  stage.force_scale = loop_.convergence().scale();
  stage.lacks_memory = loop_.system().factor().lacks_memory();
  stage.iterations = loop_.log().iterations();
  return stage;
}

void PathSolver::forget() {
  loop_.forget();
  has_tangent_ = false;
  load_unit_ = 1.0;  // as where a run is resumed
}

}  // namespace pliant
