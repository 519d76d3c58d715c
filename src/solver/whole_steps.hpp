/// The solution of a residual without a potential.
#pragma once

#include "petsc/handle.hpp"
#include "solver/iteration.hpp"
#include "solver/objective.hpp"
#include "time/stage.hpp"

namespace pliant {

/// Takes a few whole Newton steps from the guess in q, then damped ones if those do not converge; with inertia, a few
/// damped ones first. A whole step may stretch a thin body until its forces are many times those that act on it. The
/// stresses extrapolated along the step are nevertheless close to equilibrium, and the next step removes the stretch; a
/// line search that measures residuals would reject both steps. On return the aim of the objective is the usual one.
/// Collective.
StageReport solve_residual(Objective& objective, Iteration& iteration, Vec q, int max_iterations);

}  // namespace pliant
