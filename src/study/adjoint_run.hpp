/// A simulation that is followed backwards: derivatives of one number by many.
#pragma once

#include "run/history_row.hpp"
#include "solver/operator_system.hpp"
#include "study/adjoint_pair.hpp"
#include "study/adjoint_weights.hpp"
#include "time/transposed_variable.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The adjoint of a run: the derivatives of a number J by numbers p of the input, from dJ/dy of columns y of the
/// history at its steps. The steps are followed backwards, each stage with one linear system
///
///     K lambda = -dJ/dq,   dJ/dp += lambda . dr/dp + dJ/dz . dz/dp
///
/// with the Hessian K at the stage's solution, and the transposed formulas of the method between the stages; all
/// parameters share the system. (docs/theory.md, "The adjoint of a run"; Sandu 2006, On the properties of Runge-Kutta
/// discrete adjoints.) The stages are kept in memory, or computed again from states that are kept in between
/// (Griewank & Walther 2008, Evaluating Derivatives, chapter 12).
class AdjointRun {
 public:
  using Parameter = AdjointParameter;

  /// `weights`: the derivatives of J by columns of the history. `kept_steps`: how many steps are kept in memory; 0: as
  /// many as fit into 1 GiB on each rank. Throws InputError if the input has what has no adjoint, and for columns that
  /// have none. The mesh is not needed afterwards. Collective.
  AdjointRun(const Mesh& mesh, Config config, AdjointWeights weights, const std::vector<Parameter>& parameters,
             std::int64_t kept_steps);

  const Config& config() const { return config_; }
  const Model& model() const { return model_; }
  /// Runs to the end; `progress(time)` is called after each step. Throws SolveError if it fails. Collective.
  void run(const std::function<void(double)>& progress);
  /// Goes back to the start. Throws InputError if a row of the weights is at no step, SolveError if a linear system has
  /// no solution. Collective.
  void go_back(const std::function<void(double)>& progress);

  const AdjointPair& parameter(std::size_t n) const { return *pairs_[n]; }
  /// dJ by the initial displacement and velocity of the owned nodes, 0 where they are prescribed.
  Vec by_displacement() const { return by_displacement_.get(); }
  Vec by_velocity() const { return by_velocity_.get(); }
  /// dJ by the places of the owned nodes in the mesh, as far as places of probes are what J depends on.
  Vec by_position() const { return by_position_.get(); }
  std::int64_t num_steps() const { return std::ssize(times_) - 1; }
  /// Steps that were computed twice.
  std::int64_t num_repeated() const { return num_repeated_; }

 private:
  /// dJ/dy of a state y.
  struct Bars {
    Handle<Vec> q, v, z;
  };
  struct Segment {
    std::int64_t first = 0;  ///< step at which it starts
    StateInMemory state;
  };

  void require_adjoint();
  void find_steps_of_weights();
  void advance(const std::function<void(double)>& progress);
  void begin_segment();
  Bars& bars_of(std::int64_t step);
  void add_weights(std::int64_t step, Bars& bars);
  void add_to_position(const ProbeLocation& probe, int component, double weight);
  void go_back_through(const RecordedStep& step);
  void go_back_through_load_step(const RecordedStep& step);
  void go_back_to_start();
  /// Brings dJ/dY_i to dJ/dY_i0, which is in start_.
  void go_back_through(const RecordedStage& stage, Vec q, Vec v, Vec z);
  /// lambda_ = -K^-T b, 0 on prescribed entries, with the stage's Hessian.
  void solve(const RecordedStage& stage, Vec b);
  void clear_prescribed(Vec x) const;
  Vec owned_part(Vec z);
  void add_to_parameters(const RecordedStage& stage, Vec internal);

  Config config_;
  Model model_;
  std::optional<Simulation> simulation_;
  std::optional<StepRecording> recording_;
  std::vector<std::unique_ptr<AdjointPair>> pairs_;
  std::int64_t kept_steps_;
  std::int64_t num_repeated_ = 0;
  std::vector<Segment> segments_;
  std::map<std::int64_t, double> times_;  // of the steps
  std::map<std::int64_t, Bars> bars_;     // of states that later steps depend on
  AdjointWeights weights_;
  std::map<std::int64_t, std::vector<double>> weights_of_step_;  // of the columns of seeds_
  std::vector<ColumnSeed> seeds_;
  std::optional<TransposedVariable> q_, v_, z_;
  Bars start_;  // dJ/dY_i0
  Handle<Vec> lambda_, rhs_, unknowns_, algebraic_q_, algebraic_q0_, unused_, seed_, owned_, owned_z_, zero_z_;
  Handle<Vec> by_displacement_, by_velocity_, by_position_;
  std::unique_ptr<OperatorSystem> whole_;
};

}  // namespace pliant
