#include "run/solver_setup.hpp"

#include "input/analysis.hpp"
#include "solver/newton.hpp"
#include "solver/petsc_method.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Newton's tolerance relative to adaptive.relative: its residual must not be mistaken for an error of the steps.
constexpr double part_left_by_newton = 1e-4;
/// The largest displacement of an equilibrium, relative to the size of the model, or in any case [m]: beyond where
/// bodies with guides and motors go, however small, and nearer than where rounding errors of stiff bodies equal their
/// loads.
constexpr double largest_displacement = 1e6, always_allowed = 1e3;

/// Whether multigrid may take the place of a factorization. In statics and near barriers, the factorization shows
/// whether a Hessian is definite.
bool may_adapt_linear_solver(const Config& config, Model& model) {
  const StageEquation& equation = model.equation();
  return analysis_of(config) == Analysis::dynamic && find_petsc_method(method_name(config.time.method)) == nullptr &&
         equation.symmetry() != Symmetry::indefinite && !equation.has_walls() && equation.num_rank_one() == 0;
}

}  // namespace

NewtonOptions newton_options(const Config& config, const Model& model) {
  const auto& newton = config.solver.newton;
  const auto& adaptive = config.time.adaptive;
  const double relative =
      adaptive ? std::min(newton.relative, part_left_by_newton * adaptive->relative) : newton.relative;
  const bool is_slender = !config.rods.empty() || has_free_shells(config);
  const auto slenderness = is_slender ? Slenderness::some : Slenderness::none;
  const auto& bounds = model.mesh_report().bounds;
  const double size = std::hypot(bounds[3] - bounds[0], bounds[4] - bounds[1], bounds[5] - bounds[2]);
  return {relative, newton.absolute, newton.max_iterations, slenderness,
          std::max(largest_displacement * size, always_allowed)};
}

LinearKind linear_kind(const Config& config, Model& model) {
  switch (config.solver.linear) {
    case LinearSolver::cholesky:
      return LinearKind::cholesky;
    case LinearSolver::amg:
      return LinearKind::amg;
    case LinearSolver::p_multigrid:
      return LinearKind::p_multigrid;
    case LinearSolver::automatic:
      break;
  }
  if (config.volumetric == VolumetricTreatment::mixed) return LinearKind::cholesky;  // the matrix is indefinite
  const NodeLayout& layout = model.layout();
  return automatic_linear_kind(3 * layout.num_global_nodes, layout.order, may_adapt_linear_solver(config, model));
}

std::string description_of_solver(const Config& config, Model& model) {
  return fmt::format("solver: {}{}", describe(model.equation(), linear_kind(config, model)),
                     model.constraints().map() != nullptr ? ", in the unknowns that constraints leave free" : "");
}

}  // namespace pliant
