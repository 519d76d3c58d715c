/// How the stages of a run depend on a number of its input: two neighbouring inputs on the run's own stages.
#pragma once

#include "mesh/mesh.hpp"
#include "model/model.hpp"
#include "study/neighbours.hpp"
#include "study/recorded_step.hpp"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// A parameter: the number's value, the input with another value of it, and whether it is one of every cell.
struct AdjointParameter {
  double value = 0.0;
  std::function<Config(double)> make;
  bool by_cell = false;
  /// Where the number is 1 + s, with a strain s of the whole mesh: its entry (StrainedMesh).
  std::optional<std::array<std::size_t, 2>> strain = {};
  double size = 0.0;  ///< size_of_number; 0: that of the value
};

/// Derivatives of a number J by what a stage computes.
struct StageBars {
  Vec residual;  ///< the multiplier lambda of its equation, 0 on prescribed entries
  Vec q, q0;     ///< by the stage's solution and start, without what equation and internal variables depend on them
  Vec internal;  ///< by the internal variables at its end, 0 where another rank has them; nullptr if there are none
};

/// Which cell each internal variable on this rank belongs to, in the order of the vector of all terms.
std::vector<PetscInt> cells_of_internal(const IncrementalPotential& potential);

/// Sums dJ/dp of a number p over the stages of a run that is followed backwards. What the number changes in a stage are
/// central differences of residuals, of internal variables and of prescribed motions between two inputs with other
/// values of it, at the solutions of the run. All methods are collective.
class AdjointPair {
 public:
  /// `layout`: of the run's nodes. If each cell has a value of its own, the number must be one on which only integrals
  /// over cells depend. Throws as neighbours_of does.
  AdjointPair(const Mesh& mesh, const NodeLayout& layout, const AdjointParameter& parameter);

  void add_stage(const RecordedStage& stage, const StageBars& bars);
  /// The internal variables that are functions of the configuration q at the end of a step; `internal` as of StageBars.
  void add_completion(Vec q, Vec internal);
  /// The prescribed motion at the end of a step, and what a restart makes of velocities.
  void add_end(const Step& step, Vec q, Vec v);
  void add_restart(const Step& step, Vec v);
  /// The initial state.
  void add_start(Vec q, Vec v);

  double derivative() const { return total_ / spacing_; }
  /// dJ by the value of each local cell; complete on owned ones.
  std::vector<double> derivatives_of_cells() const;
  /// The sum over the cells relative to `derivative`, from what is not a part of it: 0 where the cells account for all.
  double part_not_of_cells() const;

 private:
  struct Side {
    Side(const Mesh& mesh, Config given, const NodeLayout& layout);

    Config config;
    Model model;
    PrescribedMotion motion;
    InternalVariables internal;
    Handle<Vec> q, v, q0, v0, r, z;
  };

  /// b . (above - below).
  double product(Handle<Vec> Side::*what, Vec b) const;
  void clear(Handle<Vec> Side::*what) const;
  /// The difference of the internal variables, which are in Side::z.
  void add_internal(Vec bar);

  std::unique_ptr<Side> below_, above_;
  double spacing_ = 0.0;
  double total_ = 0.0;
  std::vector<double> of_cells_;  // per local cell; empty if that is not wanted
  std::vector<PetscInt> internal_cells_;
};

}  // namespace pliant
