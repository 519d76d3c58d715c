/// Where Newton's method starts from.
#pragma once

#include "petsc/work_vector.hpp"
#include "solver/linear_system.hpp"
#include "solver/objective.hpp"
#include "solver/statistics.hpp"
#include "time/stage.hpp"

#include <optional>
#include <string>

namespace pliant {

/// The best available guess: the one with the smallest measure of the objective.
struct StartingGuess {
  double measure = 0.0;                ///< the objective's measure there [J]; not finite if there is no guess
  std::optional<std::string> failure;  ///< why there is no guess
};

/// Chooses the guess of a stage from several candidates: the given guess, the state that inertia alone would reach,
/// rigid motions, motion along with obstacles, the last solution, and the accepted state after the prescribed motion
/// (Dirichlet boundary condition) has been applied to it in increments.
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
  /// Takes the given guess as it is, as a search that continues has to.
  StartingGuess keep(Vec q);
  /// The second-best guess of the last stage by the objective's measure; nullptr if there is none.
  Vec second() const { return has_second_ ? second_.get() : nullptr; }

  /// Keeps the solution of a stage, where the next one may start.
  void remember(Vec solution);
  void forget() { has_last_ = false; }

 private:
  /// How much of the prescribed motion was applied: nothing, because the accepted state now lies beyond a barrier; a
  /// part; or all of it.
  enum class Applied { nothing, part, all };

  /// Makes the candidate the guess if it is better.
  void consider(Vec candidate, Vec q, double& measure);
  /// How much of a displacement from the accepted state, with what is prescribed, comes before the first wall.
  double max_step_to_wall(Vec accepted, Vec displacement, StageEquation::Walls walls);
  /// Shortens the displacement of the free entries from the accepted state to the candidate if it would cross a wall.
  /// False if the prescribed displacements cross it nevertheless.
  bool stop_short_of_walls(Vec accepted, Vec candidate);
  /// Considers guesses in which nodes follow obstacles that have moved onto the accepted state.
  void follow_obstacles(const StagePoint& stage, Vec q, double& measure);
  /// Considers the accepted state displaced as a whole with the prescribed nodes.
  void follow_prescribed_nodes(Vec accepted, Vec q, double& measure);
  /// Considers the accepted state after the prescribed motion. Returns a failure if no guess is left.
  std::optional<std::string> try_prescribed_motion(Vec accepted, Vec q, double& measure);
  /// Applies the prescribed motion from the accepted state to its values in q, and moves the body with it by the
  /// tangent stiffness, in as many straight displacements as necessary. q ends at the state reached. `target` has the
  /// prescribed entries of q.
  Applied apply_prescribed_motion(Vec accepted, Vec target, Vec q);
  /// Whether the prescribed motion of the step moves anything; `guess` has its values.
  bool moves_what_is_prescribed(Vec accepted, Vec guess);
  /// Whether an extrapolated state is farther from equilibrium than the start of the step after the prescribed motion.
  bool overshoots(Vec extrapolated, Vec start);
  /// Sets the prescribed entries of x to a fraction of the prescribed motion; leaves its free entries as they are.
  void prescribe(Vec x, Vec target, Vec motion, double fraction);
  /// correction_ = the displacement of all entries that the tangent stiffness at q gives for the rest of the prescribed
  /// motion, beyond `fraction`. Returns false if the tangent cannot be factorized, nullopt if no prescribed entry moves
  /// or none exerts a force.
  std::optional<bool> find_displacement(Vec q, Vec target, Vec motion, double fraction);

  Objective& objective_;
  StageEquation& equation_;
  LinearSystem& system_;
  SolverStatistics& statistics_;
  WorkVector r_, trial_, correction_, end_, second_, last_;
  bool has_second_ = false;
  bool has_last_ = false;  // last_ is the solution of the stage before
};

}  // namespace pliant
