#include "run/driven_simulation.hpp"

#include "base/text.hpp"
#include "fem/selection.hpp"
#include "input/analysis.hpp"
#include "model/mesh_source.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr const char* what_can_change =
    "loads, pressure, amount and added_volume of cavities, prescribed displacements, motions and motors of joints, "
    "tension and pull of tendons, motion of obstacles, active stress and shortening, expansion, time.step and "
    "time.min_step";

bool is_constant(const Expression& e) {
  return !e.depends_on_space() && !e.depends_on_time();
}

/// From one value to another at constant velocity.
Expression ramp(double from, double to, const Step& step) {
  const std::string part =
      fmt::format("min(max((t - {}) / {}, 0), 1)", format_number(step.time - step.dt), format_number(step.dt));
  return Expression(fmt::format("(1 - {0}) * ({1}) + {0} * ({2})", part, format_number(from), format_number(to)));
}

/// The input with changes, whose errors do not name an option of the command line.
Config read_changed(const std::string& text, const std::string& file, const std::vector<Override>& changes) {
  try {
    return read_input(text, file, changes);
  } catch (const InputError& error) {
    std::vector<Diagnostic> errors = error.diagnostics();
    for (Diagnostic& one : errors) {
      if (one.where.file.starts_with("--set ")) one.where.file.erase(0, 2);
    }
    throw InputError(std::move(errors));
  }
}

std::string keys_of(const std::vector<Override>& changes) {
  std::string keys;
  for (const Override& change : changes) keys += (keys.empty() ? "" : ", ") + change.path;
  return keys;
}

}  // namespace

DrivenSimulation::DrivenSimulation(MPI_Comm comm, const DrivenInput& input)
    : comm_(comm),
      text_(input.text),
      file_(input.file),
      changes_(input.changes),
      given_(read_changed(text_, file_, changes_)),
      config_(given_),
      formulas_(replaceable_formulas(config_)) {
  for (const ReplaceableFormula& one : formulas_) {
    vary_in_space_.push_back(one.formula->depends_on_space() ? 1 : 0);
    one.formula->make_replaceable();
  }
  const auto with_forces = [this](const Model& model) {
    auto term = std::make_unique<NodalForces>(model.layout().num_owned_nodes);
    forces_ = term.get();
    std::vector<std::unique_ptr<EnergyTerm>> terms;
    terms.push_back(std::move(term));
    return terms;
  };
  {
    const Mesh mesh = read_mesh(comm, mesh_source(config_));
    model_.emplace(mesh, config_, with_forces);
    find_surfaces(mesh);
  }
  simulation_.emplace(config_, *model_);
  if (input.files == DrivenInput::Files::written) {
    start_files();
  } else {
    row_.emplace(config_, *model_, simulation_->ledger());
    values_ = row_->values(record(), simulation_->ledger());
  }
  simulation_->forget();  // as a run does: what was looked at until now leaves no trace
}

DrivenSimulation::~DrivenSimulation() = default;

void DrivenSimulation::find_surfaces(const Mesh& mesh) {
  const NodeLayout& layout = model_->layout();
  for (const PhysicalGroup& group : mesh.groups) {
    if (group.dimension != 2) continue;
    DrivenSurface& surface = surfaces_[group.name.empty() ? std::to_string(group.tag) : group.name];
    surface.owned = nodes_of_group(mesh, layout, group);
    std::vector<std::int64_t> numbers;
    for (const PetscInt node : surface.owned) numbers.push_back(layout.global_node(node));
    surface.numbers = gathered(comm_, numbers);  // ascending, because ranks own blocks in their order
    surface.first = static_cast<std::size_t>(
        std::ranges::lower_bound(surface.numbers, static_cast<std::int64_t>(layout.first_global_node)) -
        surface.numbers.begin());
  }
}

void DrivenSimulation::start_files() {
  directory_.emplace(comm_, config_);
  recorder_.emplace(config_, *model_, simulation_->ledger(), std::nullopt);
  Checkpoints checkpoints(config_, *model_);
  directory_->start_anew(checkpoints);
  schedule_.emplace(config_.output.every, record().time);
  values_ = recorder_->record(record(), simulation_->ledger());
  write_frame();
}

void DrivenSimulation::record_step() {
  if (!recorder_) {
    values_ = row_->values(record(), simulation_->ledger());
    return;
  }
  values_ = recorder_->record(record(), simulation_->ledger());
  const bool is_due = schedule_->due(record().time);
  if (is_due || finished()) write_frame();
  if (finished()) recorder_->sync();
}

void DrivenSimulation::write_frame() {
  if (!recorder_) {
    throw InputError({file_, 0, 0},
                     "the simulation writes no files; name a directory for them when it is made: output");
  }
  if (std::exchange(last_frame_, record().step) != record().step) recorder_->write_frame(record());
}

void DrivenSimulation::follow_joints() {
  if (simulation_->analysis() != Analysis::dynamic) return;
  simulation_->restart();
}

void DrivenSimulation::advance(const std::function<void(const std::string&)>& warn) {
  constexpr double rounding = 1e-9;  // relative to a step
  if (record().time >= end_of_joint_motion_ - rounding * record().dt) {
    end_of_joint_motion_ = infinity;
    follow_joints();
  }
  MixedEquation* const mixed = model_->mixed_equation();
  const auto keep_pressures = [&](Archive& archive) {
    if (mixed != nullptr) mixed->keep(archive);
  };
  const KeptInMemory pressures(keep_pressures);
  const StepOutcome outcome = simulation_->complete_step([&](const StepOutcome& tried) {
    if (tried.kind == StepOutcome::Kind::unsolved) warn(tried.reason);
  });
  if (outcome.kind == StepOutcome::Kind::accepted) {
    if (!outcome.reason.empty()) warn(outcome.reason);
    record_step();
    return;
  }
  pressures.restore(keep_pressures);
  simulation_->forget_attempts();
  simulation_->forget();
  if (outcome.is_input_error) throw InputError({file_, 0, 0}, outcome.reason);
  throw SolveError(simulation_->in_words(outcome) + ". The simulation stays at this state");
}

bool DrivenSimulation::has_other_steps(const Config& wanted) const {
  return wanted.time.step != given_.time.step || wanted.time.min_step != given_.time.min_step;
}

std::vector<std::size_t> DrivenSimulation::changed_formulas(Config& wanted, const std::vector<Override>& changes,
                                                            const Location& where) {
  const auto refuse = [&](const std::string& why) {
    return InputError(where,
                      fmt::format("this cannot change while a simulation runs{}; what can: {}; for anything else "
                                  "make a new simulation",
                                  why, what_can_change));
  };
  const auto then = replaceable_formulas(wanted), now = replaceable_formulas(given_);
  if (then.size() != now.size()) throw refuse("");
  Config rest = wanted, before = given_;
  if (has_other_steps(wanted)) {  // from which defaults of other keys follow
    const auto without_steps = [&](std::vector<Override> all) {
      std::erase_if(all, [](const Override& one) { return one.path == "time.step" || one.path == "time.min_step"; });
      return read_changed(text_, file_, all);
    };
    rest = without_steps(changes);
    before = without_steps(changes_);
  }
  const auto of_rest = replaceable_formulas(rest);
  std::vector<std::size_t> changed;
  for (std::size_t k = 0; k < now.size(); ++k) {
    *of_rest[k].formula = *now[k].formula;
    if (then[k].formula->text() == now[k].formula->text()) continue;
    if (then[k].formula->depends_on_space() && vary_in_space_[k] == 0) {
      throw refuse(", from a formula that is uniform to one of the position");
    }
    changed.push_back(k);
  }
  if (dump(rest) != dump(before)) throw refuse("");
  return changed;
}

// The replaced formula may be on its way from a value that was set before.
Expression DrivenSimulation::replacement(std::size_t k, const Expression& by) const {
  const Expression& now = *formulas_[k].formula;
  const bool jumps = formulas_[k].kind == DrivingFormula::Kind::motion && is_constant(by) && !now.depends_on_space() &&
                     simulation_->analysis() != Analysis::static_equilibrium && !finished();
  if (!jumps) return by;
  const double from = now(0.0, 0.0, 0.0, record().time), to = by(0.0, 0.0, 0.0, 0.0);
  return from == to ? by : ramp(from, to, next_step());
}

void DrivenSimulation::set(const std::vector<Override>& changes) {
  std::vector<Override> all = changes_;
  for (const Override& change : changes) {
    std::erase_if(all, [&](const Override& earlier) { return earlier.path == change.path; });
    all.push_back(change);
  }
  Config wanted = read_changed(text_, file_, all);
  const auto changed = changed_formulas(wanted, all, {"set " + keys_of(changes), 0, 0});
  const auto by = replaceable_formulas(wanted), now = replaceable_formulas(given_);
  bool has_new_plan = has_other_steps(wanted);
  for (const std::size_t k : changed) {
    has_new_plan = has_new_plan || by[k].formula->depends_on_time() || now[k].formula->depends_on_time();
  }
  if (has_new_plan) simulation_->plan_anew(wanted);  // first: what moves takes the next step for its way
  for (const std::size_t k : changed) formulas_[k].formula->replace(replacement(k, *by[k].formula));
  changes_ = std::move(all);
  given_ = std::move(wanted);
  if (!changed.empty()) simulation_->take_changes();
  if (std::ranges::none_of(changed, [&](std::size_t k) { return formulas_[k].is_of_joint; })) return;
  end_of_joint_motion_ = finished() ? infinity : next_step().time;
  follow_joints();
}

const DrivenSurface& DrivenSimulation::surface(const std::string& name) const {
  const auto found = surfaces_.find(name);
  if (found != surfaces_.end()) return found->second;
  const auto names = surfaces();
  throw InputError({given_.mesh.file.value, 0, 0},
                   fmt::format("the mesh has no surface '{}'{}; it has {}", name, did_you_mean(name, names),
                               names.empty() ? "none with a name" : joined(names)));
}

std::vector<std::string> DrivenSimulation::surfaces() const {
  const auto names = surfaces_ | std::views::keys;
  return {names.begin(), names.end()};
}

std::vector<double> DrivenSimulation::on_surface(const DrivenSurface& surface, Vec x) const {
  std::vector<double> mine;
  const ConstArrayView values(x);
  for (const PetscInt node : surface.owned) {
    for (PetscInt i = 0; i < 3; ++i) mine.push_back(values[3 * node + i]);
  }
  return gathered(comm_, mine);
}

std::vector<double> DrivenSimulation::coordinates_on(const DrivenSurface& surface) const {
  std::vector<double> mine;
  for (const PetscInt node : surface.owned) {
    for (const double x : model_->layout().position(node)) mine.push_back(x);
  }
  return gathered(comm_, mine);
}

std::vector<double> DrivenSimulation::reactions_on(const DrivenSurface& surface) const {
  const auto held = model_->constraints().held();
  std::vector<double> mine;
  const ConstArrayView reaction(simulation_->ledger().reaction());
  for (const PetscInt node : surface.owned) {
    for (PetscInt dof = 3 * node; dof < 3 * node + 3; ++dof) {
      mine.push_back(held[static_cast<std::size_t>(dof)] != Constraints::Hold::none ? reaction[dof] : 0.0);
    }
  }
  return gathered(comm_, mine);
}

void DrivenSimulation::apply_forces(const std::string& name, std::vector<double> forces) {
  const DrivenSurface& at = surface(name);
  const auto mine = std::span(forces).subspan(3 * at.first, 3 * at.owned.size());
  applied_[name].assign(mine.begin(), mine.end());
  sum_forces();
}

void DrivenSimulation::sum_forces() {
  const std::span<double> sum = forces_->forces();
  std::ranges::fill(sum, 0.0);
  for (const auto& [name, forces] : applied_) {
    const std::vector<PetscInt>& nodes = surfaces_.at(name).owned;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      for (std::size_t i = 0; i < 3; ++i) sum[3 * static_cast<std::size_t>(nodes[n]) + i] += forces[3 * n + i];
    }
  }
}

void DrivenSimulation::move(const std::string& name, const std::vector<double>& displacements) {
  const DrivenSurface& at = surface(name);
  PrescribedDisplacement& prescribed = model_->constraints().prescribed();
  const auto is_free = [&](PetscInt node) {
    const auto first = prescribed.flags().begin() + 3 * static_cast<std::ptrdiff_t>(node);
    return std::find(first, first + 3, 0) != first + 3;
  };
  if (model_->constraints().map() != nullptr || any_rank(comm_, std::ranges::any_of(at.owned, is_free))) {
    throw InputError({file_, 0, 0},
                     fmt::format("surface '{0}' cannot be moved node by node; hold it with 'constraints: [{{surface: "
                                 "{0}, displacement: [0, 0, 0]}}]', in an input without ties, rigid parts and joints",
                                 name));
  }
  const bool is_static = simulation_->analysis() == Analysis::static_equilibrium;
  const double now = record().time, end = is_static || finished() ? now : next_step().time;
  const ConstArrayView q(record().q);
  for (std::size_t n = 0; n < at.owned.size(); ++n) {
    for (std::size_t i = 0; i < 3; ++i) {
      const PetscInt dof = 3 * at.owned[n] + static_cast<PetscInt>(i);
      prescribed.follow(dof, {q[dof], displacements[3 * (at.first + n) + i], now, end});
    }
  }
}

void DrivenSimulation::keep(Archive& archive) {
  simulation_->keep(archive);
  archive.vector("reaction", Entries::nodes, simulation_->ledger().reaction());
}

DrivenSimulation::Saved DrivenSimulation::save() {
  auto state = std::make_shared<State>();
  state->owner = identity_;
  state->kept = KeptInMemory([this](Archive& archive) { keep(archive); });
  state->changes = changes_;
  state->given = given_;
  for (const ReplaceableFormula& one : formulas_) state->formulas.push_back(one.formula->frozen());
  state->forces = applied_;
  state->paths = model_->constraints().prescribed().paths();
  state->values = values_;
  state->end_of_joint_motion = end_of_joint_motion_;
  state->schedule = schedule_;
  state->last_frame = last_frame_;
  simulation_->forget();
  return state;
}

void DrivenSimulation::restore(const Saved& saved) {
  if (saved->owner != identity_) {
    throw InputError({file_, 0, 0}, "the saved state belongs to another simulation");
  }
  changes_ = saved->changes;
  given_ = saved->given;
  for (std::size_t k = 0; k < formulas_.size(); ++k) formulas_[k].formula->replace(saved->formulas[k]);
  applied_ = saved->forces;
  sum_forces();
  model_->constraints().prescribed().set_paths(saved->paths);
  simulation_->plan_anew(given_);
  saved->kept.restore([this](Archive& archive) { keep(archive); });
  simulation_->forget();
  values_ = saved->values;
  end_of_joint_motion_ = saved->end_of_joint_motion;
  schedule_ = saved->schedule;
  last_frame_ = saved->last_frame;
  if (!recorder_) return;
  recorder_.reset();
  recorder_.emplace(config_, *model_, simulation_->ledger(), Recorded{record().step, last_frame_});
}

}  // namespace pliant
