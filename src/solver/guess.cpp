#include "solver/guess.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// Largest number of straight displacements in which a prescribed motion is applied.
constexpr int max_displacements = 30;
/// Length of the difference that gives the forces of a prescribed motion, as a fraction of the motion.
constexpr double difference_fraction = 1e-3;
/// Displacements shorter than this fraction make no progress.
constexpr double shortest_displacement = 1e-3;

/// to = from, in the prescribed entries or in the free ones.
enum class EntryKind { prescribed, free };
void copy_entries(Vec from, Vec to, const std::vector<char>& prescribed, EntryKind which) {
  const ConstArrayView source(from);
  const ArrayView target(to);
  const std::size_t n = target.span().size();
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_prescribed = i < prescribed.size() && prescribed[i] != 0;
    if (is_prescribed == (which == EntryKind::prescribed)) target[static_cast<PetscInt>(i)] = source.span()[i];
  }
}

}  // namespace

GuessSearch::GuessSearch(Objective& objective, LinearSystem& system, SolverStatistics& statistics)
    : objective_(objective),
      equation_(objective.equation()),
      system_(system),
      statistics_(statistics),
      r_(equation_),
      trial_(equation_),
      correction_(equation_),
      end_(equation_),
      second_(equation_),
      last_(equation_) {}

void GuessSearch::remember(Vec solution) {
  has_last_ = true;
  check(VecCopy(solution, last_.get()));
}

double GuessSearch::max_step_to_wall(Vec accepted, Vec displacement, StageEquation::Walls walls) {
  equation_.set_prescribed_fraction(0.0);
  const double bound = equation_.max_step_to_wall(accepted, displacement, walls);
  equation_.set_prescribed_fraction(1.0);
  return bound;
}

bool GuessSearch::stop_short_of_walls(Vec accepted, Vec candidate) {
  if (accepted == nullptr || !equation_.has_walls()) return true;
  Vec displacement = correction_.get();
  check(VecWAXPY(displacement, -1.0, accepted, candidate));
  auto walls = StageEquation::Walls::all;
  double bound = inversion_margin * max_step_to_wall(accepted, displacement, walls);
  if (!(bound > 0.0)) {
    // An obstacle has moved onto the accepted state, and no displacement is possible. The potential shows whether the
    // guess is clear of obstacles, but not whether bodies have passed each other.
    walls = StageEquation::Walls::two_sided;
    bound = inversion_margin * max_step_to_wall(accepted, displacement, walls);
  }
  if (!(bound < 1.0)) return true;
  if (!(bound > 0.0)) return false;
  ++statistics_.capped_steps;
  check(VecWAXPY(r_.get(), bound, displacement, accepted));
  copy_entries(r_.get(), candidate, equation_.prescribed(), EntryKind::free);
  // What is prescribed moves all the way nevertheless: bodies that only distances without sign hold apart could be
  // beyond each other then, with a finite potential.
  check(VecWAXPY(displacement, -1.0, accepted, candidate));
  return !(max_step_to_wall(accepted, displacement, walls) < 1.0);
}

// In the obstacle's frame the accepted state stays where it was, and no obstacle has moved onto it.
void GuessSearch::follow_obstacles(const StagePoint& stage, Vec q, double& measure) {
  const auto& prescribed = equation_.prescribed();
  const Handle<Vec> followed = equation_.make_vector(), given = equation_.make_vector();
  check(VecCopy(q, given.get()));
  for (const auto which : {StageEquation::Followers::bodies, StageEquation::Followers::near}) {
    if (!equation_.follow_obstacles(which, followed.get())) continue;
    copy_entries(given.get(), followed.get(), prescribed, EntryKind::prescribed);
    if (stop_short_of_walls(stage.accepted, followed.get())) consider(followed.get(), q, measure);
    check(VecWAXPY(trial_.get(), stage.dt, stage.v0, stage.q0));
    copy_entries(given.get(), trial_.get(), prescribed, EntryKind::prescribed);
    if (stop_short_of_walls(followed.get(), trial_.get())) consider(trial_.get(), q, measure);
  }
}

void GuessSearch::consider(Vec candidate, Vec q, double& measure) {
  const double now = objective_.measure(candidate);
  if (!(now < measure)) return;
  measure = now;
  check(VecCopy(candidate, q));
}

StartingGuess GuessSearch::keep(Vec q) {
  equation_.extrapolate_from(nullptr);
  has_second_ = false;
  return {objective_.measure(q), std::nullopt};
}

StartingGuess GuessSearch::choose(const StagePoint& stage, Vec q) {
  equation_.extrapolate_from(nullptr);
  has_second_ = false;
  const auto& prescribed = equation_.prescribed();
  Vec accepted = stage.accepted;
  double measure = stop_short_of_walls(accepted, q) ? objective_.measure(q) : std::numeric_limits<double>::infinity();
  // The state that inertia alone would reach.
  check(VecWAXPY(trial_.get(), stage.dt, stage.v0, stage.q0));
  copy_entries(q, trial_.get(), prescribed, EntryKind::prescribed);
  if (stop_short_of_walls(accepted, trial_.get())) consider(trial_.get(), q, measure);
  if (equation_.move_rigidly(trial_.get())) {
    copy_entries(q, trial_.get(), prescribed, EntryKind::prescribed);
    if (stop_short_of_walls(accepted, trial_.get())) consider(trial_.get(), q, measure);
  }
  if (!std::isfinite(measure)) follow_obstacles(stage, q, measure);
  if (!std::isfinite(measure) && has_last_) {
    // All guesses lie beyond a barrier; the last solution was on the admissible side.
    check(VecCopy(last_.get(), trial_.get()));
    copy_entries(q, trial_.get(), prescribed, EntryKind::prescribed);
    if (stop_short_of_walls(accepted, trial_.get())) consider(trial_.get(), q, measure);
  }
  if (accepted == nullptr) {
    if (std::isfinite(measure)) return {measure, std::nullopt};
    return {measure, "every guess lies beyond a barrier"};
  }
  if (std::isfinite(measure) && !objective_.is_static()) return {measure, std::nullopt};
  auto failure = try_prescribed_motion(accepted, q, measure);
  return {measure, std::move(failure)};
}

void GuessSearch::follow_prescribed_nodes(Vec accepted, Vec q, double& measure) {
  const Handle<Vec> followed = equation_.make_vector();
  check(VecCopy(q, followed.get()));
  if (!equation_.follow_prescribed_nodes(followed.get())) return;
  copy_entries(q, followed.get(), equation_.prescribed(), EntryKind::prescribed);
  if (stop_short_of_walls(accepted, followed.get())) consider(followed.get(), q, measure);
}

std::optional<std::string> GuessSearch::try_prescribed_motion(Vec accepted, Vec q, double& measure) {
  const double best = measure;
  check(VecCopy(q, second_.get()));
  const Applied applied = apply_prescribed_motion(accepted, second_.get(), q);
  has_second_ = applied == Applied::all;
  if (has_second_) measure = objective_.measure(q);
  const bool are_both_finite = has_second_ && std::isfinite(best) && std::isfinite(measure);
  if (!(measure < best) && !(are_both_finite && overshoots(second_.get(), q))) {
    check(VecSwap(q, second_.get()));
    measure = best;
  }
  has_second_ = has_second_ && std::isfinite(best);
  equation_.extrapolate_from(nullptr);
  if (!std::isfinite(measure)) follow_prescribed_nodes(accepted, q, measure);
  if (std::isfinite(measure)) return std::nullopt;
  if (applied == Applied::nothing) {
    return equation_.has_walls() ? "an obstacle or a prescribed surface moves across a gap within one step"
           : moves_what_is_prescribed(accepted, q)
               ? "a prescribed motion, of a surface or of a joint, is too large for one step"
               : "no state near the last one has finite forces and energies";
  }
  return "the prescribed displacement is too large for one step: a tetrahedron would invert, or an obstacle or "
         "another body is in the way";
}

bool GuessSearch::moves_what_is_prescribed(Vec accepted, Vec guess) {
  check(VecCopy(accepted, trial_.get()));
  equation_.set_prescribed_fraction(0.0);
  check(VecCopy(equation_.displacements(trial_.get()), end_.get()));
  copy_entries(guess, trial_.get(), equation_.prescribed(), EntryKind::prescribed);
  equation_.set_prescribed_fraction(1.0);
  check(VecAXPY(end_.get(), -1.0, equation_.displacements(trial_.get())));
  return norm(end_.get()) != 0.0;  // or not a number: no configuration fulfils the motion
}

// After a release or a jump of the loads the extrapolated state may lie beyond a
// barrier, with less energy but farther from equilibrium than the state from which the step starts.
bool GuessSearch::overshoots(Vec extrapolated, Vec start) {
  if (!objective_.is_minimised()) return false;
  objective_.gradient(start, r_.get());
  const double residual = norm(r_.get());
  objective_.gradient(extrapolated, r_.get());
  return !(norm(r_.get()) <= residual);
}

void GuessSearch::prescribe(Vec x, Vec target, Vec motion, double fraction) {
  check(VecWAXPY(trial_.get(), fraction - 1.0, motion, target));
  copy_entries(trial_.get(), x, equation_.prescribed(), EntryKind::prescribed);
  equation_.set_prescribed_fraction(fraction);
}

std::optional<bool> GuessSearch::find_displacement(Vec q, Vec target, Vec motion, double fraction) {
  Vec forces = correction_.get(), other = end_.get();
  // The derivative of the residual with respect to the fraction, by a central difference.
  const double h = difference_fraction * std::max(1.0 - fraction, shortest_displacement);
  check(VecCopy(q, other));
  prescribe(other, target, motion, fraction + h);
  objective_.gradient(other, forces);
  prescribe(other, target, motion, fraction - h);
  objective_.gradient(other, r_.get());
  check(VecAXPBY(forces, -0.5 / h, 0.5 / h, r_.get()));
  prescribe(q, target, motion, fraction);
  if (norm(forces) == 0.0) return std::nullopt;
  objective_.gradient(q, r_.get());
  check(VecAXPY(r_.get(), 1.0 - fraction, forces));
  system_.assemble(q);
  if (!system_.factorize_definite(q)) return false;
  system_.solve(r_.get(), correction_.get());
  check(VecScale(correction_.get(), -1.0));
  check(VecCopy(motion, other));
  check(VecScale(other, 1.0 - fraction));
  copy_entries(other, correction_.get(), equation_.prescribed(), EntryKind::prescribed);
  return true;
}

GuessSearch::Applied GuessSearch::apply_prescribed_motion(Vec accepted, Vec target, Vec q) {
  const auto& prescribed = equation_.prescribed();
  const Handle<Vec> motion = equation_.make_vector();
  check(VecWAXPY(motion.get(), -1.0, accepted, q));
  {
    const ArrayView entries(motion.get());
    for (std::size_t i = 0; i < entries.span().size(); ++i) {
      if (i >= prescribed.size() || !prescribed[i]) entries[static_cast<PetscInt>(i)] = 0.0;
    }
  }
  double fraction = 0.0;
  check(VecCopy(accepted, q));
  prescribe(q, target, motion.get(), 0.0);
  Applied applied = Applied::nothing;
  for (int k = 0; k < max_displacements && applied != Applied::all; ++k) {
    if (!std::isfinite(objective_.measure(q))) break;
    applied = Applied::part;
    const auto is_found = find_displacement(q, target, motion.get(), fraction);
    if (!is_found) {
      // Nothing feels it yet: all of it, or up to what stands in the way.
      check(VecCopy(motion.get(), end_.get()));
      check(VecScale(end_.get(), 1.0 - fraction));
      const double length =
          std::min(1.0, inversion_margin * equation_.max_step_to_wall(q, end_.get(), StageEquation::Walls::all));
      if (!(length > shortest_displacement)) break;
      fraction = length == 1.0 ? 1.0 : fraction + length * (1.0 - fraction);
      prescribe(q, target, motion.get(), fraction);
      if (fraction == 1.0) applied = Applied::all;
      continue;
    }
    if (!*is_found) break;
    double length = std::min(1.0, inversion_margin * equation_.max_step(q, correction_.get()));
    const double from = fraction;
    bool is_finite = false;
    while (!is_finite && length > shortest_displacement) {
      check(VecWAXPY(end_.get(), length, correction_.get(), q));
      fraction = length == 1.0 ? 1.0 : from + length * (1.0 - from);
      prescribe(end_.get(), target, motion.get(), fraction);
      is_finite = std::isfinite(objective_.measure(end_.get()));
      if (!is_finite) length *= 0.5;
    }
    if (!is_finite) break;
    objective_.move(q, end_.get());
    if (fraction == 1.0) applied = Applied::all;
  }
  equation_.set_prescribed_fraction(1.0);
  return applied;
}

}  // namespace pliant
