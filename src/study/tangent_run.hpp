/// A simulation with the derivatives of its history by numbers of the input.
#pragma once

#include "mesh/mesh.hpp"
#include "run/history_row.hpp"
#include "run/simulation.hpp"
#include "solver/operator_system.hpp"
#include "study/stage_extrapolation.hpp"
#include "study/varied_input.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// The tangent-linear model of a run: the derivatives s = dq/dp of the discrete motion by numbers p, stage by stage
/// with the stages of the method itself, its steps held. Where the stage's equation is r(q; y0, p) = 0, with y0 the
/// start that the method's formula makes of earlier states,
///
///     K s = -dr/dy0 s0 - dr/dp
///
/// is solved with the Hessian K at the stage's solution. The right-hand side, and all that follows a solution (internal
/// variables, quadratures, numbers of the history), are central differences between two neighbouring inputs, p - h and
/// p + h, which follow the run: each with its own model and the whole stage algebra, but without a solver; their
/// solutions are q -+ h s. So every number of the input has a derivative that no term need know, with an error of h^2
/// (h is 1e-5 of the number) and of rounding errors over h.
///
/// What jumps has no derivative: where friction turns from sticking to sliding or the length of a step follows the
/// error, the derivative is that of the branch that the run takes, with the steps that it takes. (docs/sensitivity.md;
/// Petzold, Li, Cao & Serban 2006, Sensitivity analysis of differential-algebraic equations.)
class TangentRun final : private StageFollower {
 public:
  /// The run of `input` with these values of its numbers, on the mesh of the input, which is not needed afterwards.
  /// `sizes`: of each number, of which a small part is a small change if its value is 0; may be empty. Throws
  /// InputError where neither larger nor smaller values are taken. `wanted`: columns whose derivatives are wanted.
  /// Collective.
  TangentRun(const Mesh& mesh, const VariedInput& input, std::span<const double> values,
             std::span<const std::string> wanted, std::span<const double> sizes = {});
  ~TangentRun() override;

  const Config& config() const { return config_; }
  const Model& model() const { return model_; }
  /// Those of history.csv.
  const std::vector<std::string>& columns() const { return row_->columns(); }
  bool finished() const { return simulation_->finished(); }
  /// Continues to the next completed step. Throws SolveError if there is none. Collective.
  void advance();

  double time() const { return simulation_->record().time; }
  /// The row of the last completed step, or of the start, and its derivative by the n-th number, NaN where it is not
  /// wanted.
  const std::vector<double>& values() const { return values_; }
  const std::vector<double>& slopes(std::size_t n) const { return slopes_[n]; }

 private:
  struct Neighbour;
  struct Pair;

  void begin_step(const Step& step) override;
  void end_stage(NewtonSolver& solver, const StagePoint& stage, Vec q) override;
  void end_step(bool restarts) override;
  void add_pair(const Mesh& mesh, const VariedInput& input, std::span<const double> values, std::size_t n, double size);
  void measure();
  /// Which coefficients a stage was solved with: those of the guess, those of its solution (StageEquation::refreeze),
  /// or these because a bound was exceeded.
  enum class Coefficients { frozen, follow, follow_beyond_bound };
  /// What the equation of a stage is at its solution.
  struct StageTangent {
    Coefficients coefficients;
    double floor;  ///< rounding errors of its residual [N]
  };
  /// Moves the unknowns of all pairs to the solutions of their stages, at this place in time; false if there are none.
  bool solve(TangentSystem& system, double place, double floor);
  /// The same for a pair, where the Hessian may leave out a part of the derivative.
  bool solve(Pair& pair, TangentSystem& system, const StageTangent& stage);
  /// Solves with the derivative of all forces, by differences along changes of this size.
  bool solve_for_whole(Pair& pair, Coefficients coefficients, TangentSystem& system, double size);

  Config config_;
  Model model_;
  std::optional<Simulation> simulation_;
  std::optional<HistoryRow> row_;
  std::vector<std::string> wanted_;
  std::vector<Pair> pairs_;
  std::vector<double> values_;
  std::vector<std::vector<double>> slopes_;
  Handle<Vec> r_, change_, scaled_;
  std::unique_ptr<OperatorSystem> whole_;
};

/// The mesh of the input. Collective.
Mesh mesh_of(MPI_Comm comm, const VariedInput& input);

}  // namespace pliant
