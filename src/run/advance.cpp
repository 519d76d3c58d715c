#include "run/advance.hpp"

#include "petsc/check.hpp"
#include "solver/petsc_integrator.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Newton's tolerance relative to adaptive.relative: its residual must not be mistaken for an error of the steps.
constexpr double part_left_by_newton = 1e-4;

NewtonOptions newton_options(const Config& config) {
  const auto& newton = config.solver.newton;
  const auto& adaptive = config.time.adaptive;
  const double relative =
      adaptive ? std::min(newton.relative, part_left_by_newton * adaptive->relative) : newton.relative;
  const bool is_slender = !config.rods.empty() || has_free_shells(config);
  const auto slenderness = is_slender ? Slenderness::some : Slenderness::none;
  return {relative, newton.absolute, newton.max_iterations, slenderness};
}

/// PETSc reads its options here, the same on every rank, so that all fail together.
template <class Make>
auto with_user_options(const Make& make) {
  try {
    return make();
  } catch (const PetscFailure& failure) {
    if (failure.code() == PETSC_ERR_MEM) throw;
    throw InputError({"PETSc options", 0, 0}, failure.what());
  }
}

/// Advances with Pliant's own Newton's method.
std::unique_ptr<NewtonSolver> make_newton(const Config& config, Model& model) {
  return with_user_options([&] {
    return std::make_unique<NewtonSolver>(model.equation(), newton_options(config), linear_kind(config, model));
  });
}

/// Newton's method, and who follows it. Without a solver, if stages are solved elsewhere.
class StageSolver {
 public:
  StageSolver(const Config& config, Model& model, Stages stages)
      : newton_(stages == Stages::solved_here ? make_newton(config, model) : nullptr) {}

  StageReport operator()(const StagePoint& stage, Vec q) {
    const StageReport report = newton_->solve(stage, q);
    if (follower_ != nullptr && report.outcome == StageOutcome::converged) follower_->end_stage(*newton_, stage, q);
    return report;
  }
  void follow(StageFollower& follower) { follower_ = &follower; }
  void forget() {
    if (newton_) newton_->forget();
  }
  std::optional<FailedStage> examine() { return newton_ ? newton_->examine() : std::nullopt; }
  void watch(std::function<void(const StageProgress&)> watcher) {
    if (newton_) newton_->watch(std::move(watcher));
  }
  const SolverStatistics& statistics() const { return newton_ ? newton_->statistics() : none_; }

 private:
  std::unique_ptr<NewtonSolver> newton_;
  StageFollower* follower_ = nullptr;
  SolverStatistics none_;
};

std::string description_of(const Config& config, Model& model) {
  return fmt::format("solver: {}{}", describe(model.equation(), linear_kind(config, model)),
                     model.constraints().map() != nullptr ? ", in the unknowns that constraints leave free" : "");
}

/// Advances in time by a method of the table, or by the user's own.
class TimeAdvance final : public Advance {
 public:
  TimeAdvance(const Config& config, Model& model, Ledger& ledger, const StateView& initial, Stages stages)
      : solver_(config, model, stages),
        description_(description_of(config, model)),
        ledger_(ledger),
        motion_(model.motion()),
        integrator_(options_of(config), system_of(model, ledger, solver_), initial) {
    if (const auto& adaptive = config.time.adaptive) {
      norm_.emplace(Tolerances{adaptive->relative, adaptive->absolute, adaptive->absolute_velocity}, initial);
    }
  }

  StepAttempt attempt(const Step& step) override { return integrator_.attempt(step); }
  void begin(const Step& step) override { stepper_ = &integrator_.begin(step); }
  const StagePoint& start_stage(Vec guess) override {
    const StagePoint& stage = stepper_->start_stage();
    check(VecCopy(guess, unknown()));
    motion_.start_stage(stage, unknown());
    return stage;
  }
  Vec unknown() const override { return stepper_->unknown(); }
  void end_stage() override { stepper_->end_stage(); }
  StepAttempt end_step() override { return stepper_->end_step(); }
  void follow(StageFollower& follower) override { solver_.follow(follower); }
  void accept(const StepAttempt& attempt) override {
    if (norm_) norm_->accept(attempt);
    integrator_.accept(attempt);
  }
  void restart() override {
    integrator_.restart();
    ledger_.book_jump(state());
    if (!state().w.empty()) integrator_.set_quadratures(ledger_.works());
  }
  void shift_works(std::span<const double> change) override {
    if (!state().w.empty()) integrator_.shift_quadratures(change);
  }
  double error(const StepAttempt& attempt) const override { return norm_ ? (*norm_)(attempt) : 0.0; }
  const Stepper* stepper() const override { return integrator_.last_stepper(); }
  StateView state() const override { return integrator_.state().view(); }
  void keep(Archive& archive) override {
    integrator_.keep(archive);
    if (norm_) norm_->keep(archive);
  }
  void forget() override { solver_.forget(); }
  std::optional<FailedStage> examine() override { return solver_.examine(); }
  void watch(std::function<void(const StageProgress&)> watcher) override { solver_.watch(std::move(watcher)); }
  const SolverStatistics& solver_statistics() const override { return solver_.statistics(); }
  std::vector<std::string> description() const override { return {description_}; }

 private:
  static IntegratorOptions options_of(const Config& config) {
    return {*integrator_of(config), config.time.startup.value(),
            config.time.adaptive ? ErrorEstimate::local : ErrorEstimate::none};
  }
  static System system_of(Model& model, Ledger& ledger, StageSolver& solver) {
    System system;
    system.solve = [&solver](const StagePoint& stage, Vec q) { return solver(stage, q); };
    system.motion = model.motion();
    system.internal = model.potential().internal_variables();
    system.quadratures = ledger.quadratures();
    system.guess = Guess::predicted;
    return system;
  }

  StageSolver solver_;
  std::string description_;
  Ledger& ledger_;
  PrescribedMotion motion_;
  Integrator integrator_;
  Stepper* stepper_ = nullptr;  // of the step that is taken stage by stage
  std::optional<ErrorNorm> norm_;
};

/// Advances in time by one of PETSc's integrators.
class PetscAdvance final : public Advance {
 public:
  PetscAdvance(const Config& config, Model& model, Ledger& ledger, const PetscMethod& method, const StateView& initial)
      : name_(method.name), ledger_(ledger), integrator_(with_user_options([&] {
          const PetscIntegratorOptions options{method, newton_options(config), linear_kind(config, model)};
          return std::make_unique<PetscIntegrator>(options, model.equation(), model.motion(Correction::of_slaves),
                                                   initial);
        })) {}

  StepAttempt attempt(const Step& step) override { return integrator_->attempt(step); }
  void accept(const StepAttempt& attempt) override { integrator_->accept(attempt); }
  void restart() override {
    integrator_->restart();
    ledger_.book_jump(state());
  }
  StateView state() const override { return integrator_->state().view(); }
  void keep(Archive& archive) override { integrator_->keep(archive); }
  void forget() override { integrator_->forget(); }
  const SolverStatistics& solver_statistics() const override { return integrator_->statistics(); }
  std::vector<std::string> description() const override {
    return {fmt::format("solver: PETSc's integrator {}, with its own Newton's method", name_)};
  }

 private:
  std::string name_;
  Ledger& ledger_;
  std::unique_ptr<PetscIntegrator> integrator_;
};

/// Advances the load factor from 0 to 1 at a fixed time; "time" of a step is the load factor.
class LoadAdvance final : public Advance {
 public:
  LoadAdvance(const Config& config, Model& model, const StateView& initial, Stages stages)
      : solver_(config, model, stages),
        description_(description_of(config, model)),
        motion_(model.constraints().motion()),
        internal_(model.potential().internal_variables()),
        time_(config.time.end) {
    for (Handle<Vec>* v : {&state_, &earlier_, &q_, &start_, &zero_, &start_velocity_})
      *v = make_vector(model.layout());
    check(VecCopy(initial.q, state_.get()));
    if (initial.z == nullptr) return;
    for (Handle<Vec>* z : {&state_z_, &z_}) check(VecDuplicate(initial.z, z->out()));
    check(VecCopy(initial.z, state_z_.get()));
  }

  StepAttempt attempt(const Step& step) override {
    begin(step);
    extrapolate(step.time);
    start_at(q_.get());
    const StageReport report = solver_(stage_, q_.get());
    StepAttempt result = report.outcome == StageOutcome::converged ? end_step() : StepAttempt{};
    result.time = step.time;
    result.report = report;
    return result;
  }

  void begin(const Step& step) override {
    stage_ = {.time = time_,
              .dt = 1.0,
              .q0 = start_.get(),
              .v0 = start_velocity_.get(),
              .load_factor = step.time,
              .step_start = time_ - 1.0,
              .z0 = state_z_.get(),
              .accepted = state_.get(),
              .accepted_z = state_z_.get()};
  }
  const StagePoint& start_stage(Vec guess) override {
    check(VecCopy(guess, q_.get()));
    start_at(q_.get());
    return stage_;
  }
  Vec unknown() const override { return q_.get(); }
  void end_stage() override {}
  StepAttempt end_step() override {
    StepAttempt result;
    result.time = stage_.load_factor;
    result.last_stage = stage_;
    result.q = result.last_q = q_.get();
    result.v = result.last_a = zero_.get();
    if (!z_) return result;
    check(VecCopy(state_z_.get(), z_.get()));
    internal_.complete_step(state_z_.get(), q_.get(), z_.get());
    result.z = z_.get();
    return result;
  }
  void follow(StageFollower& follower) override { solver_.follow(follower); }

  void accept(const StepAttempt& attempt) override {
    check(VecCopy(state_.get(), earlier_.get()));
    earlier_factor_ = std::exchange(load_factor_, attempt.time);
    check(VecCopy(attempt.q, state_.get()));
    if (state_z_) check(VecCopy(attempt.z, state_z_.get()));
  }
  StateView state() const override { return {load_factor_, state_.get(), zero_.get(), state_z_.get()}; }
  void keep(Archive& archive) override {
    archive.number("load_factor", load_factor_);
    archive.vector("q", Entries::nodes, state_.get());
    archive.number("earlier_load_factor", earlier_factor_);
    archive.vector("earlier_q", Entries::nodes, earlier_.get());
    if (state_z_) archive.vector("z", Entries::internal, state_z_.get());
  }
  void forget() override { solver_.forget(); }
  std::optional<FailedStage> examine() override { return solver_.examine(); }
  void watch(std::function<void(const StageProgress&)> watcher) override { solver_.watch(std::move(watcher)); }
  const SolverStatistics& solver_statistics() const override { return solver_.statistics(); }
  std::vector<std::string> description() const override { return {description_}; }

 private:
  /// The start of the stage, and the prescribed entries of a guess of its end.
  void start_at(Vec q) {
    motion_.start_stage(stage_, q);
    // Time stands still: prescribed functions of time have no rate.
    check(VecCopy(state_.get(), start_.get()));
    check(VecSet(start_velocity_.get(), 0.0));
  }
  /// The guess, by linear extrapolation of the last two states.
  void extrapolate(double load_factor) {
    constexpr double longest = 2.0;  // relative to the previous step
    check(VecCopy(state_.get(), q_.get()));
    const double before = load_factor_ - earlier_factor_;
    if (before <= 0.0) return;
    const double part = std::min((load_factor - load_factor_) / before, longest);
    check(VecAXPBYPCZ(q_.get(), part, -part, 1.0, state_.get(), earlier_.get()));
  }

  StageSolver solver_;
  std::string description_;
  PrescribedMotion motion_;
  StagePoint stage_;
  InternalVariables internal_;
  double time_;
  double load_factor_ = 0.0, earlier_factor_ = 0.0;
  Handle<Vec> state_, earlier_, q_, start_, zero_, start_velocity_;
  Handle<Vec> state_z_, z_;  // null if there are none
};

}  // namespace

/// Whether multigrid may take the place of a factorization. In statics and near barriers, the factorization shows
/// whether a Hessian is definite.
bool may_adapt_linear_solver(const Config& config, Model& model) {
  const StageEquation& equation = model.equation();
  return analysis_of(config) == Analysis::dynamic && find_petsc_method(method_name(config.time.method)) == nullptr &&
         equation.symmetry() != Symmetry::indefinite && !equation.has_walls() && equation.num_rank_one() == 0;
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

void Advance::begin(const Step& /*step*/) {
  throw std::logic_error("this integrator takes no steps stage by stage");
}
const StagePoint& Advance::start_stage(Vec /*guess*/) {
  throw std::logic_error("no step was begun");
}
Vec Advance::unknown() const {
  throw std::logic_error("no step was begun");
}
void Advance::end_stage() {}
StepAttempt Advance::end_step() {
  return {};
}

std::unique_ptr<Advance> make_advance(const Config& config, Model& model, Ledger& ledger, const StateView& initial,
                                      Stages stages) {
  if (analysis_of(config) == Analysis::static_equilibrium) {
    return std::make_unique<LoadAdvance>(config, model, initial, stages);
  }
  if (const PetscMethod* method = find_petsc_method(method_name(config.time.method))) {
    if (const ConstraintMap* map = model.constraints().map(); map != nullptr && !map->is_linear()) {
      throw InputError(config.time.method.where,
                       fmt::format("'{}' does not support rigid parts that rotate freely; choose one of Pliant's own "
                                   "methods",
                                   method_name(config.time.method)));
    }
    if (const auto reason = why_not(model.potential())) {
      throw InputError(config.time.method.where,
                       fmt::format("'{}' cannot be used here: {}", method_name(config.time.method), *reason));
    }
    return std::make_unique<PetscAdvance>(config, model, ledger, *method, initial);
  }
  return std::make_unique<TimeAdvance>(config, model, ledger, initial, stages);
}

}  // namespace pliant
