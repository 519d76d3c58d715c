/// How a residual without a potential is solved.
#pragma once

#include "petsc/handle.hpp"
#include "solver/iteration.hpp"
#include "solver/objective.hpp"
#include "time/stage.hpp"

namespace pliant {

/// A few whole Newton steps from the guess in q, and damped ones where they do not arrive; with inertia, a few damped
/// ones before. The stresses extrapolated along a step are near those of equilibrium even where it stretches a thin
/// body to forces many times those at work, so that the next step takes them back; a line search that measures
/// residuals would refuse both. The aim of the objective is the usual one again afterwards. Collective.
StageReport solve_residual(Objective& objective, Iteration& iteration, Vec q, int max_iterations);

}  // namespace pliant
