#include "run/advance.hpp"

#include "petsc/check.hpp"
#include "run/arc_advance.hpp"
#include "run/solver_setup.hpp"
#include "run/static_states.hpp"
#include "solver/petsc_integrator.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Advances with Pliant's own Newton's method.
std::unique_ptr<NewtonSolver> make_newton(const Config& config, Model& model) {
  return with_user_options([&] {
    return std::make_unique<NewtonSolver>(model.equation(), newton_options(config, model), linear_kind(config, model));
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

/// Advances in time by a method of the table, or by the user's own.
class TimeAdvance final : public Advance {
 public:
  TimeAdvance(const Config& config, Model& model, Ledger& ledger, const StateView& initial, Stages stages)
      : solver_(config, model, stages),
        description_(description_of_solver(config, model)),
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
          const PetscIntegratorOptions options{method, newton_options(config, model), linear_kind(config, model)};
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
        description_(description_of_solver(config, model)),
        states_(config.time.end, model, initial) {}

  StepAttempt attempt(const Step& step) override {
    begin(step);
    extrapolate();
    const StageReport report = solver_(states_.begin_stage(load_factor_, unknown()), unknown());
    StepAttempt result = report.outcome == StageOutcome::converged ? end_step() : StepAttempt{};
    result.time = result.load_factor = load_factor_;
    result.report = report;
    return result;
  }

  void begin(const Step& step) override { load_factor_ = step.time; }
  const StagePoint& start_stage(Vec guess) override {
    check(VecCopy(guess, unknown()));
    return states_.begin_stage(load_factor_, unknown());
  }
  Vec unknown() const override { return states_.unknown(); }
  void end_stage() override {}
  StepAttempt end_step() override { return states_.end_step(load_factor_); }
  void follow(StageFollower& follower) override { solver_.follow(follower); }
  void accept(const StepAttempt& attempt) override { states_.accept(attempt); }
  StateView state() const override { return states_.view(states_.load_factor()); }
  void keep(Archive& archive) override { states_.keep(archive); }
  void forget() override { solver_.forget(); }
  std::optional<FailedStage> examine() override { return solver_.examine(); }
  void watch(std::function<void(const StageProgress&)> watcher) override { solver_.watch(std::move(watcher)); }
  const SolverStatistics& solver_statistics() const override { return solver_.statistics(); }
  std::vector<std::string> description() const override { return {description_}; }

 private:
  /// The guess, by linear extrapolation of the last two states.
  void extrapolate() {
    constexpr double longest = 2.0;  // relative to the previous step
    check(VecCopy(states_.last(), unknown()));
    const double before = states_.load_factor() - states_.earlier_load_factor();
    if (before <= 0.0) return;
    const double part = std::min((load_factor_ - states_.load_factor()) / before, longest);
    check(VecAXPBYPCZ(unknown(), part, -part, 1.0, states_.last(), states_.earlier()));
  }

  StageSolver solver_;
  std::string description_;
  StaticStates states_;
  double load_factor_ = 0.0;  // of the step that is tried
};

}  // namespace

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
    if (config.time.path) return std::make_unique<ArcAdvance>(config, model, initial);
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
