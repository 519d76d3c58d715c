/// Where Newton's method starts from.
#pragma once

#include "petsc/handle.hpp"
#include "solver/linear_system.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "time/stage.hpp"

#include <optional>
#include <string>

namespace pliant {

/// The best of the guesses that there are: the one at which the objective's measure is least.
struct StartingGuess {
  double measure = 0.0;                ///< the objective's there [J]; not finite if there is none
  std::optional<std::string> failure;  ///< why there is none
};

/// Chooses the guess of a stage among the given one, where inertia alone would lead, rigid motions, the motion of
/// obstacles, the last solution, and the accepted state to which the prescribed motion (Dirichlet boundary condition)
/// has been applied step by step.
///
/// Invariants:
/// - A guess has the prescribed entries of the given one.
/// - Straight displacements from the accepted state stop short of walls.
///
/// Collective.
class GuessSearch {
 public:
  /// The references outlive the object.
  GuessSearch(Objective& objective, LinearSystem& system, SolverStatistics& statistics);

  /// On entry q holds the given guess, on return the best one.
  StartingGuess choose(const StagePoint& stage, Vec q);
  /// Another guess of the last stage, not as good in the objective's measure; nullptr if there is none.
  Vec second() const { return has_second_ ? second_.get() : nullptr; }

  /// Keeps the solution of a stage, where the next one may start.
  void remember(Vec solution);
  void forget() { has_last_ = false; }

 private:
  /// How far the prescribed motion was applied: not at all, as the accepted state lies beyond a barrier now, or a part
  /// of it, or all.
  enum class Applied { nothing, part, all };

  /// Makes the candidate the guess if it is better.
  void consider(Vec candidate, Vec q, double& measure);
  /// The candidate, or where a wall stands between the accepted state and it: short of the wall.
  void stop_short_of_walls(Vec accepted, Vec candidate);
  /// Considers guesses that obstacles which have moved onto the accepted state have taken along.
  void follow_obstacles(const StagePoint& stage, Vec q, double& measure);
  /// Considers what the prescribed motion makes of the accepted state. A failure if no guess is left.
  std::optional<std::string> try_prescribed_motion(Vec accepted, Vec q, double& measure);
  /// Applies the prescribed motion from the accepted state to where it is in q, and moves the body with it: by the
  /// tangent, in as many straight displacements as it takes; q is then where it ended. `target` has the prescribed
  /// entries of q.
  Applied apply_prescribed_motion(Vec accepted, Vec target, Vec q);
  /// x = with the prescribed motion applied to a part; its free entries stay.
  void prescribe(Vec x, Vec target, Vec motion, double fraction);
  /// correction = the displacement of all entries that the tangent at q gives for the rest of the prescribed motion,
  /// beyond `fraction`; false if there is no tangent. nullopt if nothing that is prescribed moves, or nothing feels it.
  std::optional<bool> find_displacement(Vec q, Vec target, Vec motion, double fraction);

  Objective& objective_;
  StageEquation& equation_;
  LinearSystem& system_;
  SolverStatistics& statistics_;
  Handle<Vec> r_, trial_, correction_, end_, second_, last_;
  bool has_second_ = false;
  bool has_last_ = false;  // last_ is the solution of the stage before
};

}  // namespace pliant
