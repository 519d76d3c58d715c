/// A stage: the problem, of the form of a backward Euler step, that every method of the time layer poses, and the
/// solver's answer.
#pragma once

#include "petsc/handle.hpp"
#include "time/step.hpp"

#include <functional>
#include <span>
#include <string>

namespace pliant {

/// All that a term may know of time. The vectors are borrowed and hold the stage's start; rates inside a stage are v =
/// (q - q0) / dt and a = (v - v0) / dt (docs/theory.md, "The incremental potential").
///
/// On a configuration space that is not a vector space the unknown `q` and its start `q0` are coordinates around
/// `centre` (time/space.hpp); terms of nodal positions are not affected.
struct StagePoint {
  double time = 0.0;  ///< t_i, at which loads and constraints are evaluated; just before an event, not at it [s]
  double dt = 0.0;    ///< dt_i = beta A_ii dt, length of the stage [s]
  Vec q0 = nullptr;   ///< configuration at the stage's start [m]
  Vec v0 = nullptr;   ///< velocity at the stage's start [m/s]
  double load_factor =
      1.0;  ///< multiplies loads and prescribed displacements (load stepping of static problems; else 1)
  double step_start = 0.0;  ///< t_n; functions of time are smooth from there on [s]
  Vec z0 = nullptr;         ///< internal variables at the stage's start; nullptr if there are none
  /// Set while the last stage of a step on a vector space is solved: q_{n+1} = end_rest + end_weight q. Symplectic
  /// methods are midpoint rules one after another, and it is set in each stage, for the end of its own one. Otherwise
  /// 0.
  double end_weight = 0.0;
  Vec end_rest = nullptr;    ///< nullptr: zero, as for stiffly accurate methods
  double end_time = 0.0;     ///< t_{n+1}, or that of the end of the midpoint rule, where end_weight is set [s]
  Vec centre = nullptr;      ///< q_n, around which coordinates are taken; nullptr on a vector space
  Vec accepted = nullptr;    ///< q_n on a vector space: the configuration from which the step starts [m]
  Vec accepted_z = nullptr;  ///< z_n, the internal variables from which the step starts; nullptr if there are none
};

enum class StageOutcome { converged, retry, fatal };

struct StageReport {
  StageOutcome outcome = StageOutcome::converged;
  std::string reason;  ///< the reason of a failure, for the log
  int newton_iterations = 0;
  int linear_iterations = 0;
};

/// Solves the stage's equation for q; on entry q holds the starting guess, prescribed entries already at their values.
/// Leaves q undefined unless converged. Collective; every rank gets the same report.
using StageSolve = std::function<StageReport(const StagePoint&, Vec q)>;

/// Motion prescribed on some entries of the configuration, exact in time.
struct PrescribedMotion {
  /// Sets the prescribed entries of the stage's start to q0 = q_D(t) - dt v_D(t), v0 = v_D(t) - dt a_D(t), so that the
  /// stage-local differences are exact on them, and those of the guess q to q_D(t). Collective.
  std::function<void(const StagePoint& stage, Vec q)> start_stage = [](const StagePoint&, Vec) {};
  /// Sets the prescribed entries of a completed step to q_D(t), v_D(t), t = step.time. Collective.
  std::function<void(const Step& step, Vec q, Vec v)> complete_step = [](const Step&, Vec, Vec) {};
  /// Where prescribed velocities may jump (at the start of the run and at events): sets v to the velocity after
  /// step.time that the motion prescribed from there on allows. `step.dt`: the motion is smooth over this time.
  /// Collective.
  std::function<void(const Step& step, Vec q, Vec v)> restart = [](const Step&, Vec, Vec) {};
  /// Removes from e, an estimated error of v at the end of a step at q, what the motion does not allow: the
  /// acceleration of a last stage that takes the configuration back to constraints has an error of lower order along
  /// their forces. Collective.
  std::function<void(Vec q, Vec e)> project_error = [](Vec, Vec) {};
};

/// Internal variables of the material, in y next to q and v: each obeys an ordinary differential equation of its
/// own (or is a function of q whose rate is wanted), and is found once q is. The stage algebra is that of q and v.
struct InternalVariables {
  /// z = the variables at the end of the converged stage (from stage.z0 and q). Collective.
  std::function<void(const StagePoint& stage, Vec q, Vec z)> end_stage;
  /// On entry z is the result of the method's formula for the end of a step; those that the formula does not concern
  /// are set: functions of q, and of q and z_n (nullptr at the start of the motion). Collective.
  std::function<void(Vec accepted_z, Vec q, Vec z)> complete_step = [](Vec, Vec, Vec) {};
};

/// Quadratures: integrals along the motion, dw/dt = rate(t, q, v), integrated by the method itself (energies, works).
/// They are the same numbers on every rank.
struct Quadratures {
  /// Rates at the end of the converged stage; v and a are the stage's velocity and acceleration. Collective.
  std::function<void(const StagePoint& stage, Vec q, Vec v, Vec a, std::span<double> rates)> rates;
};

}  // namespace pliant
