#include "run/run.hpp"

#include "base/file.hpp"
#include "model/unknown_counts.hpp"
#include "model/warnings.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "run/checkpoints.hpp"
#include "run/end_findings.hpp"
#include "run/energy_watch.hpp"
#include "run/frame_schedule.hpp"
#include "run/motion_watch.hpp"
#include "run/output_directory.hpp"
#include "run/overlap_file.hpp"
#include "run/post_mortem.hpp"
#include "run/recorder.hpp"
#include "run/signals.hpp"
#include "run/simulation.hpp"
#include "run/summary.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// After so many stages the mean number of their iterations is typical of the run.
constexpr int telling_stages = 3;
/// A stage that takes longer than this is reported to the user [s].
constexpr double long_stage = 30.0;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Seconds with three significant digits, never as a power of ten.
std::string three_digits(double t) {
  const int before_point = t > 0.0 ? static_cast<int>(std::floor(std::log10(t))) + 1 : 0;
  return fmt::format("{:.{}f}", t, std::clamp(3 - before_point, 0, 4));
}

class Run {
 public:
  /// From the start, or from a checkpoint that is whole.
  Run(MPI_Comm comm, const Config& config, Console& console, const TermFactory& additional, const ResumePoint* from)
      : comm_(comm),
        config_(config),
        console_(console),
        model_(comm, config, additional),
        watch_(config, model_),
        checkpoints_(config, model_) {
    directory_.emplace(comm, config);
    introduce();
    simulation_.emplace(config, model_);
    simulation_->watch([this](const StageProgress& stage) { report_long_stage(stage); });
    energy_watch_.emplace(simulation_->ledger().energies());
    for (const auto& line : simulation_->description()) console.print(line);
    std::optional<Recorded> earlier;
    if (from != nullptr) {
      since_ = " since the run was resumed";
      checkpoints_.restore(from->file, from->info, [&](Archive& archive) { keep(archive); });
      earlier = {record().step, last_frame_};
      last_row_ = record().step;
      if (simulation_->finished()) {
        console_.warn(fmt::format(
            "nothing is left to do: the checkpoint is at {} = {:.6g}{}; to extend the run, give a "
            "later end: --set {}=...",
            variable(), progress(), is_static() ? "" : " s", config.time.path ? "time.path.max_load" : "time.end"));
      }
    }
    try {
      recorder_.emplace(config, model_, simulation_->ledger(), earlier);
    } catch (const FileError& error) {
      if (!earlier) throw;
      throw FileError(fmt::format("{}. To keep these files and continue elsewhere: pliant resume {} --output DIR",
                                  error.what(), from->file.string()));
    }
    if (!earlier) {
      directory_->start_anew(checkpoints_);
      recorder_->record(record(), simulation_->ledger());
      look_at_mesh_error();
      recorder_->write_frame(record());
    }
    setup_seconds_ = seconds_since(start_);
  }

  ExitCode operator()() {
    try {
      return go();
    } catch (const FileError& error) {
      throw FileError(fmt::format("{}. {}", error.what(), what_is_left()));
    }
  }

 private:
  ExitCode go() {
    const InterruptGuard interrupt;
    FrameSchedule schedule(config_.output.every, record().time);
    const auto start = Clock::now();
    simulation_->forget();  // as after a checkpoint: what was looked at until now leaves no trace
    while (!simulation_->finished()) {
      const Request request =
          interrupt.request(comm_, checkpoints_.is_due_by_clock() ? Request::checkpoint : Request::none);
      if (request != Request::none) write_checkpoint();
      if (request == Request::stop) return interrupted();
      const StepOutcome outcome = simulation_->advance();
      if (outcome.kind == StepOutcome::Kind::failed) give_up(outcome);
      if (outcome.kind == StepOutcome::Kind::unsolved) console_.warn(outcome.reason);
      warn_of_iterations(telling_stages);
      if (outcome.kind != StepOutcome::Kind::accepted) continue;
      if (!outcome.reason.empty()) console_.warn(outcome.reason);
      recorder_->record(record(), simulation_->ledger());
      look_at_mesh_error();
      last_row_ = record().step;
      report_critical_point();
      if (simulation_->analysis() == Analysis::dynamic)
        energy_watch_->look(simulation_->ledger().energies(), record().time,
                            model_.potential().rounding_energy(record().q));
      if (multigrid_is_news()) {
        console_.warn(
            "the factorization ran out of memory; algebraic multigrid takes its place (as `solver.linear: amg`)");
      }
      if (record().newton_iterations > worst_.newton_iterations) {
        worst_ = {record().step, progress(), record().newton_iterations};
      }
      if (const auto news = watch_.look_for_passage(record())) console_.warn(*news);
      for (const auto& news : watch_.look_at_joints(record())) console_.warn(news);
      for (const auto& news : watch_.look_at_tendons(record())) console_.warn(news);
      last_frame_written_ = schedule.due(record().time) || simulation_->finished();
      if (last_frame_written_) {
        recorder_->write_frame(record());
        last_frame_ = record().step;
        for (const auto& news : watch_.look(record())) console_.warn(news);
      }
      if (checkpoints_.is_due(record().step)) write_checkpoint();
      const std::string line = progress_line(seconds_since(start));
      if (console_.is_terminal()) {
        console_.progress(line);
      } else if (last_frame_written_) {
        console_.print(line);
      }
    }
    config_.checkpoint ? write_checkpoint() : recorder_->sync();
    for (const auto& words : watch_.final_warnings()) console_.warn(words);
    if (const std::string& why = simulation_->end_of_path(); !why.empty()) {
      console_.print(fmt::format("the path ends: {}", why));
    }
    summarise("done", "");
    return ExitCode::done;
  }

  const StepRecord& record() const { return simulation_->record(); }
  bool is_static() const { return analysis_of(config_) == Analysis::static_equilibrium; }
  /// The time, or the load factor of a static problem.
  double progress() const { return is_static() ? record().load_factor : record().time; }
  const char* variable() const { return is_static() ? "load factor" : "t"; }

  void introduce() {
    console_.print(fmt::format("{}: {}, {} unknowns, {} rank{}", config_.title.empty() ? config_.file : config_.title,
                               in_words(model_.mesh_report().elements), count_unknowns(config_, model_).all,
                               num_ranks(comm_), num_ranks(comm_) == 1 ? "" : "s"));
    for (const auto& notice : model_.mesh_report().notices) console_.note(notice);
    for (const auto& diagnostic : model_.diagnostics()) console_.report(diagnostic);
  }

  void keep(Archive& archive) {
    simulation_->keep(archive);
    const Archive::Section section(archive, "run");
    archive.number("last_frame", last_frame_);
    archive.number("worst_step", worst_.step);
    archive.number("worst_time", worst_.time);
    archive.number("worst_newton_iterations", worst_.newton_iterations);
    archive.number("largest_energy", largest_energy_);
    std::size_t num_critical = critical_points_.size();
    archive.number("num_critical_points", num_critical);
    critical_points_.resize(num_critical);
    for (std::size_t k = 0; k < num_critical; ++k) {
      const Archive::Section point(archive, fmt::format("critical_point_{}", k));
      archive.number("step", critical_points_[k].step);
      int kind = static_cast<int>(critical_points_[k].point.kind);
      archive.number("kind", kind);
      critical_points_[k].point.kind = static_cast<CriticalPoint::Kind>(kind);
      archive.number("load_factor", critical_points_[k].point.load_factor);
    }
    energy_watch_->keep(archive);
    mesh_error_watch_.keep(archive);
  }

  void write_checkpoint() {
    recorder_->sync();
    checkpoints_.write(record().step, record().time, [&](Archive& archive) { keep(archive); });
    // Makes this run continue exactly as one that resumes from the checkpoint.
    simulation_->forget();
  }

  /// After a file could not be written: the files that exist, and how to continue. Not collective: each rank reports
  /// what it sees.
  std::string what_is_left() const {
    std::error_code ignored;
    if (!std::filesystem::exists(config_.output.directory, ignored)) {
      return "The output directory is gone, with all results: start the run again";
    }
    const auto files = checkpoints_in(config_.output.directory);
    const std::string what_to_do =
        files.empty()
            ? "no checkpoint; once files can be written again, start the run again (with `checkpoint: {every: 100}` it "
              "can be resumed)"
            : fmt::format("{}; once files can be written again, continue with: {}", files.front().filename().string(),
                          how_to_resume());
    return fmt::format("The files are intact: rows up to step {}, frames up to step {}, {}", last_row_, last_frame_,
                       what_to_do);
  }

  bool multigrid_is_news() {
    const bool is_used = simulation_->solver_statistics().uses_multigrid_instead;
    return is_used && !std::exchange(multigrid_is_reported_, is_used);
  }

  std::string how_to_resume() const { return fmt::format("pliant resume {}", config_.output.directory); }

  ExitCode interrupted() {
    if (!last_frame_written_) recorder_->write_frame(record());
    summarise("interrupted", "");
    console_.warn(fmt::format(
        "interrupted after step {} at {} = {:.6g}{}; the results so far are in {}; to continue: {}", record().step,
        variable(), progress(), is_static() ? "" : " s", config_.output.directory, how_to_resume()));
    return ExitCode::interrupted;
  }

  /// To be called last: it leaves the model in the state that could not be solved.
  std::string post_mortem(const StepOutcome& outcome) {
    try {
      return write_post_mortem(config_, model_, record(),
                               {outcome.reason, outcome.tried, simulation_->examine(), outcome.is_input_error});
    } catch (const FileError& error) {
      return error.what();
    }
  }

  [[noreturn]] void give_up(const StepOutcome& outcome) {
    if (!last_frame_written_) recorder_->write_frame(record());
    write_checkpoint();
    const std::string where_to_look = post_mortem(outcome);
    summarise("failed", outcome.reason);
    throw SolveError(
        fmt::format("{0}. The last good state ({1} = {2:.6g}) is in {3}{4}. Post-mortem: {5}",
                    simulation_->in_words(outcome), variable(), progress(), config_.output.directory,
                    is_static() ? "" : fmt::format(" (`{} --set time.step=...` continues from there)", how_to_resume()),
                    where_to_look));
  }

  double output_seconds() const { return recorder_->seconds() + checkpoints_.seconds(); }

  std::string progress_line(double elapsed) {
    const Energies& e = simulation_->ledger().energies();
    const bool has_end = std::isfinite(simulation_->plan().end);
    const double done = record().time / simulation_->plan().end;
    largest_energy_ =
        std::max({largest_energy_, e.kinetic, e.elastic, std::abs(e.load_potential), std::abs(e.load_work)});
    const std::string left =
        has_end ? fmt::format("{:.0f} s left", elapsed * (1.0 - done) / std::max(done, 1e-12)) : stability();
    return fmt::format("{} {:.6g}{}  step {}  dt {:.3g}  newton {}  energy balance {:+.1e}  {}", variable(), progress(),
                       is_static() ? "" : " s", record().step, record().dt, record().newton_iterations,
                       e.balance_error / std::max(largest_energy_, 1e-300), left);
  }

  /// Whether the last state on a path is stable, in words.
  std::string stability() const {
    if (!record().unstable_modes) return "";
    return *record().unstable_modes == 0 ? "stable" : fmt::format("unstable ({})", *record().unstable_modes);
  }

  /// A limit point or bifurcation that the last step has passed.
  void report_critical_point() {
    if (!record().critical) return;
    critical_points_.push_back({record().step, *record().critical});
    console_.note(fmt::format("step {} has passed {}", record().step, in_words(*record().critical)));
  }

  /// Without inertia there is no kinetic energy, and steps of the load or of time do not damp.
  std::string energy_line() const {
    const Energies& e = simulation_->ledger().energies();
    const bool moves = simulation_->analysis() == Analysis::dynamic;
    return fmt::format(
        "energy [J]: {}elastic {:.6g}, load potential {:.6g}; since the start: work of loads {:.6g}, of prescribed "
        "motion {:.6g}, dissipated {:.6g}, {} {:.6g}; balance {:+.3g}",
        moves ? fmt::format("kinetic {:.6g}, ", e.kinetic) : "", e.elastic, e.load_potential,
        e.load_work - e.support_work, e.support_work, e.dissipated, moves ? "by the method" : "lost between equilibria",
        e.numerical_dissipation, e.balance_error);
  }

  void save(const Summary& summary) {
    try {
      on_root(comm_, [&] { write_summary(config_.output.directory, summary); });
    } catch (const FileError& error) {
      console_.warn(error.what());  // the run itself is safe
    }
  }

  void summarise(const char* outcome, const std::string& message) {
    const SolverStatistics& s = simulation_->solver_statistics();
    const StepStatistics& steps = simulation_->steps();
    const RunSeconds t{seconds_since(start_),   setup_seconds_,  model_.mesh_seconds(), s.assembly_seconds,
                       s.factorization_seconds, s.solve_seconds, output_seconds()};
    console_.print(fmt::format(
        "time: {} s = set-up {} (mesh {}) + assembly {} + factorization {} + solve {} + output {} + rest {}",
        three_digits(t.total), three_digits(t.set_up), three_digits(t.mesh), three_digits(t.assembly),
        three_digits(t.factorization), three_digits(t.solve), three_digits(t.output), three_digits(t.rest())));
    console_.print(fmt::format("steps: {} from {:.3g} to {:.3g}{}; {} repeated after a failed solve, {} for accuracy",
                               steps.accepted, steps.shortest, steps.longest, is_static() ? "" : " s", steps.failed,
                               steps.inaccurate));
    console_.print(fmt::format(
        "newton: {} iterations in {} stages{}, {} of them minimised, {} solved on the residual; {} factorizations, {} "
        "linear iterations, {} step lengths rejected, {} steps capped before inversion, {} Hessians projected, {} "
        "shifted, {} stages ended at rounding errors",
        s.newton_iterations, s.stages, since_, s.minimisations, s.residual_solves, s.factorizations,
        s.linear_iterations, s.backtracks, s.capped_steps, s.projections, s.regularizations, s.rounding_stops));
    if (worst_.newton_iterations >= 0) {
      console_.print(fmt::format("worst step: {} at {} = {:.6g} with {} Newton iterations", worst_.step, variable(),
                                 worst_.time, worst_.newton_iterations));
    }
    console_.print(energy_line());
    report_mesh_error(outcome);
    for (const Diagnostic& diagnostic : findings()) console_.report(diagnostic);
    warn_of_iterations(1);
    console_.print(fmt::format("results: {0}/result.xdmf, {0}/history.csv", config_.output.directory));
    for (const auto& option : unused_petsc_options()) {
      console_.warn(fmt::format("no solver used the PETSc option {}; is it misspelt?", option));
    }
    // Last: it has all warnings and notes.
    save({outcome, message, num_ranks(comm_), t, steps, s, worst_, energy_watch_->growth(),
          recorder_->fields().has_mesh_error() ? std::optional(mesh_error_watch_) : std::nullopt, critical_points_,
          console_.warnings(), console_.notes()});
  }

  void look_at_mesh_error() {
    ResultFields& fields = recorder_->fields();
    if (fields.has_mesh_error()) mesh_error_watch_.look(fields.mesh_error(record()), progress());
  }

  void report_mesh_error(std::string_view outcome) {
    if (!recorder_->fields().has_mesh_error()) {
      if (outcome != "done") return;
      const auto note = note_about_linear_elements(model_, config_, record(), simulation_->ledger().energies());
      if (note) console_.report(*note);
      return;
    }
    const std::string when =
        fmt::format("{} = {:.6g}{}", variable(), mesh_error_watch_.time(), is_static() ? "" : " s");
    console_.print(in_words(mesh_error_watch_, when));
    if (const auto warning = warning_about(mesh_error_watch_, config_)) console_.warn(to_string(*warning));
  }

  /// Reports a stage that takes long, and again each time its duration has doubled.
  void report_long_stage(const StageProgress& stage) {
    if (stage.iteration == 0 && stage.seconds < long_stage) reported_at_ = 0.0;
    // Newton's method may begin again within a stage, as where friction settles.
    if (stage.seconds < last_progress_.seconds) {
      earlier_iterations_ = 0;
    } else if (stage.iteration < last_progress_.iteration) {
      earlier_iterations_ += last_progress_.iteration;
    }
    last_progress_ = stage;
    if (stage.seconds < std::max(long_stage, 2.0 * reported_at_)) return;
    reported_at_ = stage.seconds;
    console_.print(
        fmt::format("note: the step after {} = {:.6g}{} takes long: {:.0f} s so far, {} Newton iterations, residual "
                    "{:.1e} N (tolerance {:.1e} N), {} linear iterations in the last one",
                    variable(), progress(), is_static() ? "" : " s", stage.seconds,
                    earlier_iterations_ + stage.iteration, stage.residual, stage.target, stage.linear_iterations));
  }

  /// Once, when so many stages have been solved, or have failed.
  void warn_of_iterations(long long least_stages) {
    const SolverStatistics& s = simulation_->solver_statistics();
    if (iterations_are_reported_ || s.stages < least_stages) return;
    const double iterations = static_cast<double>(s.newton_iterations) / static_cast<double>(s.stages);
    for (const Diagnostic& warning : warnings_about_iterations(config_, iterations)) {
      console_.warn(to_string(warning));
      iterations_are_reported_ = true;
    }
  }

  /// What the run as a whole shows, at its end. Collective.
  std::vector<Diagnostic> findings() const {
    const SolverStatistics& s = simulation_->solver_statistics();
    const bool is_dynamic = simulation_->analysis() == Analysis::dynamic;
    std::vector<Diagnostic> found = findings_about_solutions(
        config_, s, is_dynamic && energy_watch_->sees_only_rounding() ? Forces::none_but_rounding : Forces::some);
    std::ranges::move(findings_about_contact(config_, model_, record()), std::back_inserter(found));
    const Ledger& ledger = simulation_->ledger();
    const double longest = simulation_->steps().longest;
    std::ranges::move(is_dynamic ? findings_about_energy(config_, *energy_watch_, ledger.energies(), longest)
                                 : findings_about_equilibria(config_, ledger),
                      std::back_inserter(found));
    return found;
  }

  Clock::time_point start_ = Clock::now();
  std::string_view since_;  // when the statistics count, in words
  MPI_Comm comm_;
  const Config& config_;
  Console& console_;
  Model model_;
  MotionWatch watch_;
  MeshErrorWatch mesh_error_watch_;
  std::vector<PassedPoint> critical_points_;
  std::optional<OutputDirectory> directory_;
  Checkpoints checkpoints_;
  std::optional<Simulation> simulation_;
  std::optional<Recorder> recorder_;
  double setup_seconds_ = 0.0;
  bool last_frame_written_ = true;
  std::int64_t last_row_ = 0;  // step of the last row of the history
  bool multigrid_is_reported_ = false, iterations_are_reported_ = false;
  std::int64_t last_frame_ = 0;  // step of the last frame that was due
  double largest_energy_ = 0.0;  // so far [J]
  std::optional<EnergyWatch> energy_watch_;
  WorstStep worst_;
  double reported_at_ = 0.0;     // duration of the stage at its last report [s]
  StageProgress last_progress_;  // of the stage that is being solved
  int earlier_iterations_ = 0;   // of its solves before the present one
};

}  // namespace

ExitCode run_with_output(MPI_Comm comm, const Config& config, Console& console, const TermFactory& additional) {
  try {
    return Run(comm, config, console, additional, nullptr)();
  } catch (const OverlapError& error) {
    throw with_overlap_file(comm, config, error);
  }
}

ExitCode resume_with_output(MPI_Comm comm, const Config& config, Console& console, const ResumePoint& from,
                            const TermFactory& additional) {
  return Run(comm, config, console, additional, &from)();
}

}  // namespace pliant
