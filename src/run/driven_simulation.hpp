/// A simulation that a program drives: it takes the steps one by one, changes loads and prescribed motions between
/// them, exchanges forces and displacements on surfaces, and returns to earlier states.
#pragma once

#include "base/limits.hpp"
#include "energy/load/nodal_forces.hpp"
#include "input/input.hpp"
#include "model/events.hpp"
#include "model/model.hpp"
#include "petsc/kept_in_memory.hpp"
#include "run/frame_schedule.hpp"
#include "run/history_row.hpp"
#include "run/output_directory.hpp"
#include "run/recorder.hpp"
#include "run/simulation.hpp"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// What a driven simulation starts from.
struct DrivenInput {
  enum class Files { none, written };
  std::string text;               ///< YAML, the same on every rank
  std::string file;               ///< its name, for messages; files that it names are relative to its directory
  std::vector<Override> changes;  ///< as by --set
  Files files = Files::none;      ///< written: history and frames in the input's output directory, as by `pliant run`
};

/// The nodes of a named surface of the mesh.
struct DrivenSurface {
  std::vector<PetscInt> owned;        ///< local nodes, ascending
  std::vector<std::int64_t> numbers;  ///< global numbers of all nodes, ascending, the same on every rank
  std::size_t first = 0;              ///< row of the first owned node among them
};

/// The steps are those of `pliant run`: Simulation takes them. All methods are collective unless said otherwise, and
/// throw on every rank what they throw on one: InputError, SolveError, FileError.
class DrivenSimulation {
  struct State;

 public:
  /// Builds the model. `comm` outlives the object.
  DrivenSimulation(MPI_Comm comm, const DrivenInput& input);
  DrivenSimulation(const DrivenSimulation&) = delete;
  DrivenSimulation& operator=(const DrivenSimulation&) = delete;
  ~DrivenSimulation();

  const Config& config() const { return config_; }
  const Model& model() const { return *model_; }
  const StepRecord& record() const { return simulation_->record(); }
  bool finished() const { return simulation_->finished(); }
  /// The step that the next `advance` tries first. Not when finished.
  Step next_step() const { return simulation_->next_step(); }
  const std::vector<std::string>& columns() const { return recorder_ ? recorder_->columns() : row_->columns(); }
  /// The row of the history at the last completed step, or at the start.
  const std::vector<double>& row() const { return values_; }

  /// Completes a step; calls `warn` for attempts that are repeated. After a failure (SolveError; InputError where a
  /// formula is not finite) the simulation is at the last completed step, as it was. Not when finished.
  void advance(const std::function<void(const std::string&)>& warn);

  /// Replaces values of the input from the next step on: formulas of loads, of the contents of cavities, of prescribed
  /// motions, motors, tendons, obstacles and active stress; `time.step`, `time.min_step`. A constant that prescribes a
  /// motion is reached at the end of the next step, at constant velocity. InputError, and no change, for what the input
  /// does not take and for everything else.
  void set(const std::vector<Override>& changes);

  /// A named surface; InputError if the mesh has none of this name. Not collective.
  const DrivenSurface& surface(const std::string& name) const;
  std::vector<std::string> surfaces() const;
  /// xyz of its nodes on every rank, in the order of their numbers.
  std::vector<double> on_surface(const DrivenSurface& surface, Vec x) const;
  std::vector<double> coordinates_on(const DrivenSurface& surface) const;
  /// Reactions of constraints on the body at its nodes at the end of the last step [N]; 0 in directions that are free.
  std::vector<double> reactions_on(const DrivenSurface& surface) const;
  /// Forces on its nodes from now on [N], xyz in the order of their numbers, the same on every rank; in addition to
  /// those on other surfaces.
  void apply_forces(const std::string& surface, std::vector<double> forces);
  /// Displacements of its nodes at the end of the next step, reached at constant velocity and kept from then on [m],
  /// likewise; a static problem multiplies them by its load factor. InputError unless constraints prescribe all of
  /// them, without ties.
  void move(const std::string& surface, const std::vector<double>& displacements);

  /// A state to which `restore` returns: with everything that was set. It belongs to this simulation.
  using Saved = std::shared_ptr<const State>;
  /// From here on, the steps are the same to the last bit as after restoring the state.
  Saved save();
  /// Collective. Files lose what was written after that state.
  void restore(const Saved& saved);

  /// Adds a frame to the result. InputError without files.
  void write_frame();

 private:
  struct State {
    std::shared_ptr<const char> owner;  // identity_
    KeptInMemory kept;
    std::vector<Override> changes;
    Config given;
    std::vector<Expression> formulas;
    std::map<std::string, std::vector<double>> forces;
    std::map<PetscInt, PrescribedDisplacement::Path> paths;
    std::vector<double> values;
    double end_of_joint_motion;
    std::optional<FrameSchedule> schedule;
    std::int64_t last_frame = 0;
  };

  void find_surfaces(const Mesh& mesh);
  void start_files();
  void keep(Archive& archive);
  void record_step();
  void sum_forces();
  bool has_other_steps(const Config& wanted) const;
  /// The numbers of the formulas that differ in another input. Throws InputError if anything else does.
  std::vector<std::size_t> changed_formulas(Config& wanted, const std::vector<Override>& changes,
                                            const Location& where);
  /// Velocities of joints jump where a motion that was set for them begins or ends.
  void follow_joints();
  /// What a formula is replaced by.
  Expression replacement(std::size_t k, const Expression& by) const;

  MPI_Comm comm_;
  // Its address is that of no other simulation while a state of this one exists.
  std::shared_ptr<const char> identity_ = std::make_shared<const char>();
  std::string text_, file_;
  std::vector<Override> changes_;  // so far
  Config given_;                   // as the user has it now
  Config config_;                  // of the start, with formulas that can be replaced; others refer to it
  std::vector<ReplaceableFormula> formulas_;
  std::vector<char> vary_in_space_;  // whether a formula does in the input
  std::map<std::string, DrivenSurface> surfaces_;
  std::map<std::string, std::vector<double>> applied_;  // by surface, of its owned nodes [N]
  NodalForces* forces_ = nullptr;
  std::optional<Model> model_;
  std::optional<Simulation> simulation_;
  double end_of_joint_motion_ = infinity;  // of motions that were set for joints [s]; infinity: there are none
  std::vector<double> values_;
  std::optional<HistoryRow> row_;  // without files
  std::optional<OutputDirectory> directory_;
  std::optional<Recorder> recorder_;
  std::optional<FrameSchedule> schedule_;
  std::int64_t last_frame_ = -1;  // step of the last frame
};

}  // namespace pliant
