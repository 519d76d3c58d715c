#include "app/simulation.hpp"

#include "app/ledger.hpp"
#include "app/model.hpp"
#include "app/recorder.hpp"
#include "app/signals.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "solver/newton.hpp"
#include "time/integrator.hpp"
#include "time/method.hpp"
#include "time/step_control.hpp"

#include <chrono>
#include <cmath>
#include <functional>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

LinearKind linear_kind(const Config& config, const NodeLayout& layout) {
  if (config.solver.linear == "cholesky") return LinearKind::cholesky;
  if (config.solver.linear == "amg") return LinearKind::amg;
  return automatic_linear_kind(3 * layout.num_global_nodes);
}

/// What moves the state from one step to the next; a step's outcome is only a proposal until it is accepted.
class Advance {
 public:
  virtual ~Advance() = default;
  virtual StepAttempt attempt(const Step& step) = 0;
  virtual void accept(const StepAttempt& attempt) = 0;
};

/// In time, by a method of the table.
class TimeAdvance final : public Advance {
 public:
  TimeAdvance(Model& model, StageSolve solve, const Method& method, Vec q, Vec v)
      : integrator_({method}, {std::move(solve), model.prescribed().motion()}, {0.0, q, v}) {}

  StepAttempt attempt(const Step& step) override { return integrator_.attempt(step); }
  void accept(const StepAttempt& attempt) override { integrator_.accept(attempt); }

 private:
  Integrator integrator_;
};

/// Along the load factor from 0 to 1, at one time; "time" of a step is the load factor.
class LoadAdvance final : public Advance {
 public:
  LoadAdvance(Model& model, StageSolve solve, double time, Vec q)
      : solve_(std::move(solve)), motion_(model.prescribed().motion()), time_(time) {
    for (Handle<Vec>* v : {&state_, &q_, &start_, &zero_, &start_velocity_}) *v = make_vector(model.layout());
    check(VecCopy(q, state_.get()));
  }

  StepAttempt attempt(const Step& step) override {
    check(VecCopy(state_.get(), q_.get()));
    check(VecCopy(state_.get(), start_.get()));
    check(VecSet(start_velocity_.get(), 0.0));
    StepAttempt result;
    result.time = step.time;
    result.last_stage = {time_, 1.0, start_.get(), start_velocity_.get(), step.time, time_ - 1.0};
    motion_.start_stage(result.last_stage, q_.get());
    result.report = solve_(result.last_stage, q_.get());
    result.q = result.last_q = q_.get();
    result.v = result.last_a = zero_.get();
    return result;
  }

  void accept(const StepAttempt& attempt) override { check(VecCopy(attempt.q, state_.get())); }

 private:
  StageSolve solve_;
  PrescribedMotion motion_;
  double time_;
  Handle<Vec> state_, q_, start_, zero_, start_velocity_;
};

/// Frames are due at multiples of the output interval, at the first step at or after them.
class FrameSchedule {
 public:
  explicit FrameSchedule(double interval) : interval_(interval) {}
  bool due(double time) {
    const auto reached = static_cast<long long>(std::floor(time / interval_ * (1.0 + 1e-12) + 1e-9));
    if (reached <= last_) return false;
    last_ = reached;
    return true;
  }

 private:
  double interval_;
  long long last_ = 0;
};

/// The steps that needed most.
struct WorstStep {
  std::int64_t step = 0;
  double time = 0.0;
  int newton_iterations = -1;
};

class Run {
 public:
  Run(MPI_Comm comm, const Config& config, Console& console)
      : comm_(comm), config_(config), console_(console), analysis_(analysis_of(config)), model_(comm, config) {
    introduce();
    q_ = make_vector(model_.layout());
    v_ = make_vector(model_.layout());
    if (analysis_ == Analysis::static_equilibrium) {
      check(VecZeroEntries(q_.get()));
    } else {
      model_.set_initial_state(config, q_.get(), v_.get());
    }
    const LinearKind kind = linear_kind(config, model_.layout());
    make_solver(kind);
    console.print(fmt::format("solver: Newton, {}", describe(kind)));
    make_advance();
    ledger_.emplace(model_, analysis_, q_.get(), v_.get());
    recorder_.emplace(comm, config, model_);
    setup_seconds_ = seconds_since(start_);
  }

  ExitCode operator()() {
    const InterruptGuard interrupt;
    FrameSchedule schedule(config_.output.every.value_or(plan_.dt));
    StepRecord record{0, 0.0, 0.0, 0, 0, q_.get(), v_.get(), nullptr};
    recorder_->record(record, *ledger_);
    recorder_->write_frame(record);
    StepControl control(plan_);
    const auto start = Clock::now();
    while (!control.finished()) {
      if (interrupt.interrupted(comm_)) {
        if (!last_frame_written_) recorder_->write_frame(record_of_state(record));
        summarise();
        console_.warn(fmt::format("interrupted after step {} at t = {:.6g} s; what was computed is in {}", record.step,
                                  record.time, config_.output.directory));
        return ExitCode::interrupted;
      }
      const Step step = control.next();
      const StepAttempt attempt = advance_->attempt(step);
      if (attempt.report.outcome != StageOutcome::converged) {
        give_up_or_shorten(control, step, attempt, record);
        continue;
      }
      ledger_->book(attempt);
      advance_->accept(attempt);
      control.accept();
      check(VecCopy(attempt.q, q_.get()));
      check(VecCopy(attempt.v, v_.get()));
      record = {record.step + 1,
                step.time,
                step.dt,
                attempt.report.newton_iterations,
                attempt.report.linear_iterations,
                q_.get(),
                v_.get(),
                analysis_ == Analysis::dynamic ? attempt.last_a : nullptr};
      recorder_->record(record, *ledger_);
      if (record.newton_iterations > worst_.newton_iterations) {
        worst_ = {record.step, record.time, record.newton_iterations};
      }
      last_frame_written_ = schedule.due(step.time) || control.finished();
      if (last_frame_written_) recorder_->write_frame(record);
      const std::string line = progress_line(record, seconds_since(start));
      if (console_.is_terminal()) {
        console_.progress(line);
      } else if (last_frame_written_) {
        console_.print(line);
      }
    }
    summarise();
    return ExitCode::done;
  }

 private:
  void introduce() {
    const NodeLayout& layout = model_.layout();
    console_.print(fmt::format("{}: {} tetrahedra, {} unknowns, {} rank{}",
                               config_.title.empty() ? config_.file : config_.title, layout.num_global_cells,
                               3 * layout.num_global_nodes, num_ranks(comm_), num_ranks(comm_) == 1 ? "" : "s"));
    for (const auto& notice : model_.mesh().report.notices) console_.print("note: " + notice);
    for (const auto& notice : model_.notices()) console_.print("note: " + notice);
  }

  /// PETSc reads its options here, the same on every rank, so that all fail together.
  void make_solver(LinearKind kind) {
    const auto& newton = config_.solver.newton;
    try {
      solver_.emplace(model_.potential(), NewtonOptions{newton.relative, newton.absolute, newton.max_iterations}, kind);
    } catch (const PetscFailure& failure) {
      if (failure.code() == PETSC_ERR_MEM) throw;
      throw InputError({"PETSc options", 0, 0}, failure.what());
    }
  }

  void make_advance() {
    StageSolve solve = [this](const StagePoint& stage, Vec q) { return solver_->solve(stage, q); };
    if (analysis_ == Analysis::static_equilibrium) {
      advance_ = std::make_unique<LoadAdvance>(model_, std::move(solve), config_.time.end, q_.get());
      const double step = 1.0 / config_.time.load_steps;
      plan_ = {0.0, step, 1.0, step / 1024.0};
    } else {
      const Method* method =
          find_method(analysis_ == Analysis::quasistatic ? "backward-euler" : config_.time.method.value);
      advance_ = std::make_unique<TimeAdvance>(model_, std::move(solve), *method, q_.get(), v_.get());
      plan_ = {0.0, config_.time.step, config_.time.end, config_.time.min_step};
    }
  }

  StepRecord record_of_state(StepRecord record) const {
    record.a = nullptr;  // it belonged to the step that was given up
    return record;
  }

  void give_up_or_shorten(StepControl& control, const Step& step, const StepAttempt& attempt,
                          const StepRecord& record) {
    ++rejected_;
    const bool may_retry = attempt.report.outcome == StageOutcome::retry;
    if (control.reject(attempt.report.reason).retry == Retry::again && may_retry) {
      console_.warn(fmt::format("step to {} = {:.6g} failed ({}); trying half of it", variable(), step.time,
                                attempt.report.reason));
      return;
    }
    if (!last_frame_written_) recorder_->write_frame(record_of_state(record));
    summarise();
    throw SolveError(fmt::format(
        "the solve failed at {0} = {1:.6g}: {2}{3}. The last good state ({0} = {4:.6g}) is in {5}. What may "
        "help: {6}, a finer or better mesh where it deforms most, weaker loads; `-- -snes_monitor` shows "
        "Newton's method at work",
        variable(), step.time, attempt.report.reason,
        may_retry ? fmt::format("; half the step is below the smallest allowed, {:.3g}", plan_.min_dt) : "",
        record.time, config_.output.directory,
        analysis_ == Analysis::static_equilibrium ? "more load_steps" : "a smaller time.step"));
  }

  const char* variable() const { return analysis_ == Analysis::static_equilibrium ? "load factor" : "t"; }

  std::string progress_line(const StepRecord& record, double elapsed) {
    const Energies& e = ledger_->energies();
    const double done = record.time / plan_.end;
    largest_energy_ =
        std::max({largest_energy_, e.kinetic, e.elastic, std::abs(e.load_potential), std::abs(e.load_work)});
    return fmt::format("{} {:.6g}{}  step {}  dt {:.3g}  newton {}  energy balance {:+.1e}  {:.0f} s left", variable(),
                       record.time, analysis_ == Analysis::static_equilibrium ? "" : " s", record.step, record.dt,
                       record.newton_iterations, e.balance_error / std::max(largest_energy_, 1e-300),
                       elapsed * (1.0 - done) / std::max(done, 1e-12));
  }

  void summarise() {
    const SolverStatistics& s = solver_->statistics();
    const double total = seconds_since(start_);
    const double known =
        setup_seconds_ + s.assembly_seconds + s.factorization_seconds + s.solve_seconds + recorder_->seconds();
    console_.print(
        fmt::format("time: {:.2f} s = set-up {:.2f} + assembly {:.2f} + factorization {:.2f} + solve {:.2f} + output "
                    "{:.2f} + rest {:.2f}",
                    total, setup_seconds_, s.assembly_seconds, s.factorization_seconds, s.solve_seconds,
                    recorder_->seconds(), total - known));
    console_.print(
        fmt::format("newton: {} iterations in {} stages; {} factorizations, {} linear iterations, {} step lengths "
                    "refused, {} steps capped before inversion, {} Hessians projected, {} shifted, {} stages ended at "
                    "rounding, {} steps repeated",
                    s.newton_iterations, s.stages, s.factorizations, s.linear_iterations, s.backtracks, s.capped_steps,
                    s.projections, s.regularizations, s.rounding_stops, rejected_));
    if (worst_.newton_iterations >= 0) {
      console_.print(fmt::format("worst step: {} at {} = {:.6g} with {} Newton iterations", worst_.step, variable(),
                                 worst_.time, worst_.newton_iterations));
    }
    const Energies& e = ledger_->energies();
    console_.print(fmt::format(
        "energy [J]: kinetic {:.6g}, elastic {:.6g}, load potential {:.6g}, work of loads {:.6g}, balance {:+.3g}",
        e.kinetic, e.elastic, e.load_potential, e.load_work, e.balance_error));
    console_.print(fmt::format("results: {0}/result.xdmf, {0}/history.csv", config_.output.directory));
    for (const auto& option : unused_petsc_options()) {
      console_.warn(fmt::format("PETSc option {} was not used by any object; is it misspelt?", option));
    }
  }

  Clock::time_point start_ = Clock::now();
  MPI_Comm comm_;
  const Config& config_;
  Console& console_;
  Analysis analysis_;
  Model model_;
  Handle<Vec> q_, v_;
  std::optional<NewtonSolver> solver_;
  std::unique_ptr<Advance> advance_;
  StepPlan plan_;
  std::optional<Ledger> ledger_;
  std::optional<Recorder> recorder_;
  double setup_seconds_ = 0.0;
  bool last_frame_written_ = true;
  int rejected_ = 0;
  double largest_energy_ = 0.0;  // so far [J]
  WorstStep worst_;
};

}  // namespace

ExitCode simulate(MPI_Comm comm, const Config& config, Console& console) {
  return Run(comm, config, console)();
}

}  // namespace pliant
