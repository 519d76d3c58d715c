// Where NewtonSolver starts from.
#include "base/stopwatch.hpp"
#include "petsc/array_view.hpp"
#include "solver/newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// Straight ways on which what is prescribed is led.
constexpr int max_ways = 30;
/// Of the difference by which the forces of a prescribed motion are found, in parts of the motion.
constexpr double difference_part = 1e-3;
/// Shorter ways than this part lead nowhere.
constexpr double shortest_way = 1e-3;

/// to = from in the entries that are prescribed, or in the others.
void copy_entries(Vec from, Vec to, const std::vector<char>& prescribed, bool of_prescribed) {
  const ConstArrayView source(from);
  const ArrayView target(to);
  const std::size_t n = target.span().size();
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_prescribed = i < prescribed.size() && prescribed[i] != 0;
    if (is_prescribed == of_prescribed) target[static_cast<PetscInt>(i)] = source.span()[i];
  }
}

}  // namespace

void NewtonSolver::stop_short_of_walls(Vec accepted, Vec candidate) {
  if (accepted == nullptr) return;
  Vec way = correction_.get();
  check(VecWAXPY(way, -1.0, accepted, candidate));
  const double bound = inversion_margin * equation_.max_way(accepted, way);
  // Where a wall has moved onto the accepted state there is no way, and the guess is as good as its value.
  if (!(bound > 0.0 && bound < 1.0)) return;
  ++statistics_.capped_steps;
  check(VecWAXPY(r_.get(), bound, way, accepted));
  copy_entries(r_.get(), candidate, equation_.prescribed(), false);
}

// In the frame of the obstacle the accepted state is where it was, and nothing has moved onto it.
void NewtonSolver::go_with_obstacles(const StagePoint& stage, Vec q) {
  const auto& prescribed = equation_.prescribed();
  const Handle<Vec> carried = equation_.make_vector(), given = equation_.make_vector();
  check(VecCopy(q, given.get()));
  for (const auto which : {StageEquation::Carried::bodies, StageEquation::Carried::near}) {
    if (!equation_.carry_along(which, carried.get())) continue;
    copy_entries(given.get(), carried.get(), prescribed, true);
    consider(carried.get(), q);
    check(VecWAXPY(trial_.get(), stage.dt, stage.v0, stage.q0));
    copy_entries(given.get(), trial_.get(), prescribed, true);
    stop_short_of_walls(carried.get(), trial_.get());
    consider(trial_.get(), q);
  }
}

void NewtonSolver::consider(Vec candidate, Vec q) {
  const double phi = height(candidate);
  if (!(phi < phi_)) return;
  phi_ = phi;
  check(VecCopy(candidate, q));
}

std::optional<std::string> NewtonSolver::choose_guess(const StagePoint& stage, Vec q) {
  equation_.extrapolate_from(nullptr);
  has_second_guess_ = false;
  const auto& prescribed = equation_.prescribed();
  Vec accepted = stage.accepted;
  stop_short_of_walls(accepted, q);
  phi_ = height(q);
  // Where inertia alone would lead.
  check(VecWAXPY(trial_.get(), stage.dt, stage.v0, stage.q0));
  copy_entries(q, trial_.get(), prescribed, true);
  stop_short_of_walls(accepted, trial_.get());
  consider(trial_.get(), q);
  if (equation_.move_rigidly(trial_.get())) {
    copy_entries(q, trial_.get(), prescribed, true);
    stop_short_of_walls(accepted, trial_.get());
    consider(trial_.get(), q);
  }
  if (!std::isfinite(phi_)) go_with_obstacles(stage, q);
  if (!std::isfinite(phi_) && last_is_known_) {
    // All lie beyond a barrier, on whose right side the last solution was.
    check(VecCopy(last_.get(), trial_.get()));
    copy_entries(q, trial_.get(), prescribed, true);
    consider(trial_.get(), q);
  }
  if (accepted == nullptr) {
    if (std::isfinite(phi_)) return std::nullopt;
    return "every guess lies beyond a barrier";
  }
  if (std::isfinite(phi_) && !is_static_) return std::nullopt;
  const double best = phi_;
  check(VecCopy(q, guess_.get()));
  const Carried carried = carry(accepted, q);
  has_second_guess_ = carried == Carried::all_the_way;
  if (has_second_guess_) phi_ = height(q);
  if (!(phi_ < best)) {
    check(VecSwap(q, guess_.get()));
    phi_ = best;
  }
  has_second_guess_ = has_second_guess_ && std::isfinite(best);
  equation_.extrapolate_from(nullptr);
  if (std::isfinite(phi_)) return std::nullopt;
  if (carried == Carried::not_at_all) return "an obstacle has moved onto the body within one step";
  return "what is prescribed cannot move as far within one step: a tetrahedron turns inside out, or an obstacle "
         "stands in its way";
}

NewtonSolver::Carried NewtonSolver::carry(Vec accepted, Vec q) {
  const auto& prescribed = equation_.prescribed();
  const Handle<Vec> given = equation_.make_vector(), forces = equation_.make_vector();
  check(VecWAXPY(given.get(), -1.0, accepted, q));
  {
    const ArrayView entries(given.get());
    for (std::size_t i = 0; i < entries.span().size(); ++i) {
      if (i >= prescribed.size() || !prescribed[i]) entries[static_cast<PetscInt>(i)] = 0.0;
    }
  }
  Vec target = guess_.get();  // whose prescribed entries are at their end
  double part = 0.0;
  // q at a part of the way: its free entries as they are.
  const auto lead = [&](Vec x, double to) {
    check(VecWAXPY(trial_.get(), to - 1.0, given.get(), target));
    copy_entries(trial_.get(), x, prescribed, true);
    equation_.lead(to);
  };
  check(VecCopy(accepted, q));
  lead(q, 0.0);
  Carried carried = Carried::not_at_all;
  for (int k = 0; k < max_ways && carried != Carried::all_the_way; ++k) {
    if (!std::isfinite(height(q))) break;
    carried = Carried::partly;
    // d/d part of the residual, by a central difference.
    const double h = difference_part * std::max(1.0 - part, shortest_way);
    check(VecCopy(q, last_trial_.get()));
    lead(last_trial_.get(), part + h);
    equation_.gradient(last_trial_.get(), forces.get());
    lead(last_trial_.get(), part - h);
    equation_.gradient(last_trial_.get(), r_.get());
    check(VecAXPBY(forces.get(), -0.5 / h, 0.5 / h, r_.get()));
    lead(q, part);
    if (norm(forces.get()) == 0.0) {  // nothing that is prescribed moves, or nothing feels it
      lead(q, 1.0);
      carried = Carried::all_the_way;
      break;
    }
    equation_.gradient(q, r_.get());
    check(VecAXPY(r_.get(), 1.0 - part, forces.get()));
    assemble(q, Projection::none);
    if (!factorize_definite(q)) break;
    solve_linear(r_.get(), correction_.get());
    // The way of all entries, what is prescribed included.
    check(VecScale(correction_.get(), -1.0));
    check(VecCopy(given.get(), forces.get()));
    check(VecScale(forces.get(), 1.0 - part));
    copy_entries(forces.get(), correction_.get(), prescribed, true);
    double length = std::min(1.0, inversion_margin * equation_.max_step(q, correction_.get()));
    const double from = part;
    bool is_finite = false;
    while (!is_finite && length > shortest_way) {
      check(VecWAXPY(last_trial_.get(), length, correction_.get(), q));
      part = length == 1.0 ? 1.0 : from + length * (1.0 - from);
      lead(last_trial_.get(), part);
      is_finite = std::isfinite(height(last_trial_.get()));
      if (!is_finite) length *= 0.5;
    }
    if (!is_finite) break;
    go_to(last_trial_.get(), q);
    if (part == 1.0) carried = Carried::all_the_way;
  }
  equation_.lead(1.0);
  return carried;
}

}  // namespace pliant
