#include "run/simulation.hpp"

#include "base/error.hpp"
#include "input/analysis.hpp"
#include "input/checks.hpp"
#include "model/events.hpp"
#include "model/joint_turns.hpp"
#include "petsc/check.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Steps of equal length differ by rounding errors up to this factor.
constexpr double longer = 1.0 + 1e-6;
/// Number of nominal steps after which a contact no longer counts as an impact.
constexpr double steps_of_impact = 3.0;
/// Longest step along a path, in first steps, if none is given.
constexpr double longest_step_of_path = 10.0;
/// Largest gain relative to the available energy: a step that gains more at a barrier is shortened, but not below this
/// fraction of the nominal step.
constexpr double largest_gain = 0.02, least_part_of_impact = 1.0 / 200.0;

StepOutcome::Kind outcome_of(const RetryDecision& decision, StepOutcome::Kind otherwise) {
  return decision.retry == Retry::give_up ? StepOutcome::Kind::failed : otherwise;
}

/// Whether, without inertia, only contact can hold bodies.
bool only_contact_holds(const Config& config) {
  return analysis_of(config) != Analysis::dynamic && config.contact && config.constraints.empty() &&
         !is_held_by_springs_or_joints(config);
}

}  // namespace

Simulation::Simulation(const Config& config, Model& model, Stages stages, Books books)
    : analysis_(analysis_of(config)), books_(books), model_(model), turns_(config) {
  q_ = make_vector(model.layout());
  v_ = make_vector(model.layout());
  if (analysis_ != Analysis::static_equilibrium) {
    model.set_initial_state(config, q_.get(), v_.get());
  } else {
    model.check_contact_at_start(q_.get());
  }
  forget_turns(model.constraints().joints());
  follow_turns(model.constraints().joints(), q_.get(), v_.get());
  const Handle<Vec> z = model.potential().make_internal();
  if (z.get() != nullptr) model.potential().internal_variables().complete_step(nullptr, q_.get(), z.get());
  StateView initial{0.0, q_.get(), v_.get(), z.get()};
  if (analysis_ == Analysis::static_equilibrium) initial.load_factor = record_.load_factor = 0.0;
  ledger_.emplace(model, analysis_, initial);
  if (analysis_ == Analysis::dynamic && books_ == Books::kept) initial.w = ledger_->works();
  advance_ = make_advance(config, model, *ledger_, initial, stages);
  set_plan(config);
  control_.emplace(plan_);
  accepted_ = control_->progress();
  for (Vec x : {q_.get(), v_.get()}) update_ghosts(x);
  record_.q = q_.get();
  record_.v = v_.get();
  record_.z = advance_->state().z;
  next_q_ = make_vector(model.layout());
  const Method* method = integrator_of(config);
  only_contact_holds_ = only_contact_holds(config);
  may_go_far_ = !config.joints.empty() || !config.rigid_bodies.empty();
  settles_pressures_ = model_.mixed_equation() != nullptr && method != nullptr && !method->stiffly_accurate;
  num_past_ = analysis_ != Analysis::dynamic ? 1 : method != nullptr ? method->num_steps : 2;
  measure_contact();
  if (config.time.path) record_.unstable_modes = 0;  // nothing has been loaded
  if (config.time.path) path_end_ = std::make_unique<PathEnd>(config, model, *ledger_);
}

Simulation::~Simulation() = default;

void Simulation::set_plan(const Config& config) {
  if (analysis_ == Analysis::static_equilibrium) {
    const double step = 1.0 / config.time.load_steps;
    plan_ = {0.0, step, 1.0, step / 1024.0};
    plan_.variable = {"load factor", ""};
    if (const auto& path = config.time.path) {
      plan_.end = std::numeric_limits<double>::infinity();
      plan_.path = PathPlan{std::max(step, path->max_step.value_or(longest_step_of_path * step))};
      plan_.variable.name = "path length";
    }
    return;
  }
  plan_ = {0.0, config.time.step, config.time.end, config.time.min_step, events_of(config).times};
  if (const auto& adaptive = config.time.adaptive) {
    const Method& method = *integrator_of(config);
    plan_.adaptive =
        AdaptivePlan{adaptive->max_step, config.output.every.value_or(0.0), method.max_growth, estimate_order(method)};
  }
}

void Simulation::keep(Archive& archive) {
  const auto part = [&](const char* name, const auto& keep_part) {
    const Archive::Section section(archive, name);
    keep_part();
  };
  part("advance", [&] { advance_->keep(archive); });
  // The energies that the ledger computes need whole turns and pressures.
  part("joints", [&] { keep_turns(model_.constraints().joints(), archive); });
  if (MixedEquation* mixed = model_.mixed_equation()) part("mixed", [&] { mixed->keep(archive); });
  part("control", [&] {
    StepProgress progress = control_->progress();
    double step = plan_.dt;
    progress.keep(archive);
    archive.number("step", step);
    if (!archive.restores()) return;
    continue_control(progress, step);
  });
  part("record", [&] {
    archive.number("step", record_.step);
    archive.number("time", record_.time);
    archive.number("dt", record_.dt);
    archive.number("newton_iterations", record_.newton_iterations);
    archive.number("linear_iterations", record_.linear_iterations);
    archive.number("contact_start", contact_start_);
    archive.number("steps_since_restart", steps_since_restart_);
  });
  // The run that is resumed ended at an event, or has one there now.
  const bool restarts =
      archive.restores() && control_->starts_at_event() && !control_->finished() && steps_since_restart_ > 0;
  part("ledger", [&] { ledger_->keep(archive, advance_->state(), restarts ? Side::before : Side::after); });
  part("steps", [&] {
    archive.number("accepted", steps_.accepted);
    archive.number("failed", steps_.failed);
    archive.number("inaccurate", steps_.inaccurate);
    archive.number("shortest", steps_.shortest);
    archive.number("longest", steps_.longest);
  });
  if (!archive.restores()) return;
  limit_steps(false);
  turns_.forget();
  moved_in_all_ = grown_ = last_growth_ = 0.0;
  take_state(advance_->state().q, advance_->state().v);
  record_.z = advance_->state().z;
  record_.load_factor = advance_->state().load_factor;
  steps_.least_gap = std::numeric_limits<double>::infinity();
  measure_contact();
  if (path_has_ended()) control_->stop();
  if (restarts) restart();
}

bool Simulation::path_has_ended() {
  if (path_end_ == nullptr) return false;
  end_of_path_ = path_end_->reason(record_, *ledger_, advance_->path()->is_at_end);
  return !end_of_path_.empty();
}

void Simulation::continue_control(StepProgress progress, double former_step) {
  if (former_step != plan_.dt) progress.limit = StepControl(plan_).progress().limit;
  control_.emplace(plan_, under_plan(plan_, progress));
  accepted_ = control_->progress();
}

void Simulation::plan_anew(const Config& config) {
  const double former_step = plan_.dt;
  set_plan(config);
  continue_control(control_->progress(), former_step);
}

std::string Simulation::in_words(const StepOutcome& failure) const {
  return fmt::format("the solve failed at {} = {:.6g}: {}",
                     analysis_ == Analysis::static_equilibrium ? "load factor" : "t",
                     analysis_ == Analysis::static_equilibrium ? record_.load_factor : record_.time, failure.reason);
}

StepOutcome Simulation::complete_step(const std::function<void(const StepOutcome&)>& retried) {
  for (;;) {
    StepOutcome outcome = advance();
    if (outcome.kind == StepOutcome::Kind::accepted || outcome.kind == StepOutcome::Kind::failed) return outcome;
    if (retried) retried(outcome);
  }
}

std::optional<StepOutcome> Simulation::shorten_turn() {
  if (advance_->path() != nullptr) return std::nullopt;  // whose steps end where nobody knows yet
  for (;;) {
    const Step step = control_->next();
    const auto reason = turns_.too_far(record_.time, step.time);
    if (!reason) return std::nullopt;
    const RetryDecision decision = control_->reject(*reason);
    if (decision.retry == Retry::again && warned_of_turns_) continue;
    warned_of_turns_ = true;
    return StepOutcome{outcome_of(decision, StepOutcome::Kind::unsolved), decision.reason, step};
  }
}

StepOutcome Simulation::advance() {
  if (auto outcome = shorten_turn()) return *outcome;
  const Step step = control_->next();
  if (follower_ != nullptr) follower_->begin_step(step);
  StepAttempt attempt = advance_->attempt(step);
  record_.a = nullptr;  // it belonged to the advance
  if (attempt.report.outcome == StageOutcome::converged) {
    if (settles_pressures_)
      model_.mixed_equation()->settle(attempt.q, model_.instant(attempt.time, attempt.load_factor));
    if (auto reason = impossibility(attempt, step)) {
      attempt.report.outcome = StageOutcome::retry;
      attempt.report.reason = std::move(*reason);
    }
  }
  if (attempt.report.outcome != StageOutcome::converged) return reject(attempt, step);
  const double error = advance_->error(attempt);
  std::string concession = control_->concession(error);
  if (!control_->accepts(error) && concession.empty()) {
    ++steps_.inaccurate;
    const RetryDecision decision = control_->reject_error(error);
    const SolverStatistics& solves = solver_statistics();
    const bool is_rounding = decision.retry == Retry::give_up && 2 * solves.rounding_stops > solves.stages;
    return {outcome_of(decision, StepOutcome::Kind::inaccurate),
            decision.reason + (is_rounding ? ", unless rounding limits it: most solves ended at the limit of double "
                                             "precision; allow a larger error, or use dirk33, whose steps are longer"
                                           : ""),
            step};
  }
  const bool touched = record_.contact.num_points > 0.0;
  const bool is_on_path = advance_->path() != nullptr;
  if (auto jump = turns_.accept(is_on_path ? record_.load_factor : record_.time,
                                is_on_path ? attempt.load_factor : step.time)) {
    concession = concession.empty() ? std::move(*jump) : concession + "; " + *jump;
  }
  accept(attempt, step);
  if (const PathFinding* path = advance_->path()) {
    control_->accept_on_path(attempt.time, path->growth);
    if (path_has_ended()) control_->stop();
  } else {
    control_->accept(error);
  }
  accepted_ = control_->progress();
  const bool touches = touched || record_.contact.num_points > 0.0;
  const bool extrapolates = extrapolates_impact(step, touches);
  const bool restarts = (control_->at_event() && !control_->finished()) || extrapolates;
  if (restarts) restart();
  if (follower_ != nullptr) follower_->end_step(restarts);
  return {StepOutcome::Kind::accepted, std::move(concession), step};
}

void Simulation::restart() {
  advance_->restart();
  steps_since_restart_ = 0;
  record_.z = advance_->state().z;
}

void Simulation::follow(StageFollower& follower) {
  follower_ = &follower;
  advance_->follow(follower);
}

void Simulation::begin(const Step& step) {
  step_ = step;
  advance_->begin(step);
}

void Simulation::end_step(bool restarts) {
  const StepAttempt attempt = advance_->end_step();
  record_.a = nullptr;
  if (settles_pressures_) model_.mixed_equation()->settle(attempt.q, model_.instant(attempt.time, attempt.load_factor));
  accept(attempt, step_);
  if (restarts) restart();
}

// The formula of a multistep method extrapolates the velocity of past steps. With steps of one length and one formula,
// it returns exactly the velocity change of an impact: 1 = 2/3 (1 + 1/3 + 1/9 ...) with bdf2. It returns more, up to
// five times as much, if steps become longer, and if an impact falls into a step of the start-up.
bool Simulation::extrapolates_impact(const Step& step, bool touches) {
  ++steps_since_restart_;
  if (!touches) contact_start_ = step.time;
  if (num_past_ == 1 || !touches || control_->finished()) return false;
  const bool grows = control_->next().dt > longer * step.dt;
  const bool is_impact = step.time - contact_start_ <= steps_of_impact * plan_.dt;
  return grows || (is_impact && steps_since_restart_ < num_past_);
}

void Simulation::take_state(Vec q, Vec v) {
  check(VecCopy(q, q_.get()));
  check(VecCopy(v, v_.get()));
  for (Vec x : {q_.get(), v_.get()}) update_ghosts(x);
}

void Simulation::measure_contact() {
  if (model_.contacts() == nullptr) return;
  record_.contact = model_.contacts()->closeness(record_.instant(model_), ConstGhostedView(q_.get()).span());
  steps_.least_gap = std::min(steps_.least_gap, record_.contact.gap);
}

std::optional<std::string> Simulation::passage(const StepAttempt& attempt) {
  if (model_.contacts() == nullptr) return std::nullopt;
  check(VecCopy(attempt.q, next_q_.get()));
  update_ghosts(next_q_.get());
  const ConstGhostedView from(q_.get()), to(next_q_.get());
  return model_.contacts()->passage(record_.instant(model_), from.span(),
                                    model_.instant(attempt.time, attempt.load_factor), to.span());
}

bool Simulation::ends_inside_out(const StepAttempt& attempt) {
  if (attempt.q == attempt.last_q) return false;  // the line search has excluded it
  const auto energies =
      model_.potential().accounts().energies(model_.instant(attempt.time, attempt.load_factor), attempt.q, attempt.z);
  return !std::ranges::all_of(energies, [](double energy) { return std::isfinite(energy); });
}

// An equilibrium is not so far away, but solves end there where nothing holds a body: its forces are small relative to
// the rounding errors of its place.
std::optional<std::string> Simulation::escape(const StepAttempt& attempt) {
  constexpr double far = 1e4;  // sizes of the model
  if (analysis_ == Analysis::dynamic) return std::nullopt;
  const auto& box = model_.mesh_report().bounds;
  const double size = std::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
  check(VecWAXPY(next_q_.get(), -1.0, q_.get(), attempt.q));
  check(VecNorm(next_q_.get(), NORM_INFINITY, &moved_));
  if (moved_ <= far * size || may_go_far_) return std::nullopt;
  return fmt::format("bodies have moved by {:.1e} m: nothing holds them against the loads", moved_);
}

// If inertia carries the start of a stage beyond a barrier, the stage throws the body back fast enough to leave the
// barrier within the stage, and damping acts with the weight of the stage, not with the duration of the impact.
std::optional<std::string> Simulation::gain_at_barrier(const StepAttempt& attempt, const Step& step) {
  const Contacts* contacts = model_.contacts();
  if (contacts == nullptr || !contacts->has_barrier() || step.dt < least_part_of_impact * plan_.dt) return std::nullopt;
  const Ledger::Gain gain = ledger_->gain(attempt);
  if (!(gain.created > largest_gain * gain.available)) return std::nullopt;
  if (!(record_.contact.num_points > 0.0)) {
    check(VecCopy(attempt.q, next_q_.get()));
    update_ghosts(next_q_.get());
    const ConstGhostedView to(next_q_.get());
    if (!(contacts->closeness(model_.instant(attempt.time, attempt.load_factor), to.span()).num_points > 0.0))
      return std::nullopt;
  }
  return fmt::format("the step is too long for an impact on a barrier: it creates {:.3g} J, with {:.3g} J available",
                     gain.created, gain.available);
}

std::optional<std::string> Simulation::impossibility(const StepAttempt& attempt, const Step& step) {
  for (const Vec x : {attempt.q, attempt.v}) {
    PetscReal size = 0.0;
    check(VecNorm(x, NORM_2, &size));
    if (!std::isfinite(size)) return "the state at the end of the step is not finite";
  }
  if (auto far = escape(attempt)) return far;
  if (ends_inside_out(attempt)) {
    return "a tetrahedron is inside out at the end of the step, although not in any of its stages: the method combines "
           "all of them";
  }
  if (advance_->path() != nullptr) {
    if (auto too_far = turns_.too_far(record_.load_factor, attempt.load_factor)) return too_far;
  }
  if (auto passes = passage(attempt)) return passes;
  return gain_at_barrier(attempt, step);
}

StepOutcome Simulation::reject(const StepAttempt& attempt, const Step& step) {
  ++steps_.failed;
  limit_steps(true);
  if (attempt.report.outcome == StageOutcome::fatal) return {StepOutcome::Kind::failed, attempt.report.reason, step};
  try {
    if (analysis_ != Analysis::static_equilibrium) model_.require_finite(attempt.time);
  } catch (const InputError& error) {
    return {StepOutcome::Kind::failed, error.what(), step, true};  // a shorter step would not help
  }
  const RetryDecision decision = control_->reject(attempt.report.reason);
  const bool gives_up = decision.retry == Retry::give_up;
  return {outcome_of(decision, StepOutcome::Kind::unsolved), decision.reason + (gives_up ? limit_in_sight() : ""),
          step};
}

std::string Simulation::limit_in_sight() const {
  constexpr double fast = 5.0;
  if (only_contact_holds_) {
    return "; only contact holds the bodies: an equilibrium exists only if friction balances the loads";
  }
  if (!(last_growth_ * grown_ > fast * moved_in_all_)) return "";
  return fmt::format(
      "; displacements grow {:.0f} times as fast as on average, so that there may be no equilibrium under larger loads "
      "(ballooning, buckling, collapse, sliding away): 'path' of a static analysis follows equilibria past a limit "
      "point, cavities whose volume is controlled ('liquid') stay stable, and inertia carries bodies on",
      last_growth_ * grown_ / moved_in_all_);
}

void Simulation::limit_steps(bool is_limited) {
  if (model_.contacts() != nullptr) model_.contacts()->limit_steps(is_limited);
}

void Simulation::accept(const StepAttempt& attempt, const Step& step) {
  limit_steps(false);
  if (books_ == Books::kept) ledger_->book(attempt);
  take_state(attempt.q, attempt.v);
  // A step along a path may end elsewhere.
  const bool is_as_planned = advance_->path() == nullptr;
  record_ = {record_.step + 1,
             is_as_planned ? step.time : attempt.time,
             is_as_planned ? step.dt : attempt.time - record_.time,
             attempt.report.newton_iterations,
             attempt.report.linear_iterations,
             q_.get(),
             v_.get(),
             analysis_ == Analysis::dynamic ? attempt.last_a : nullptr,
             nullptr,
             {},
             attempt.load_factor};
  if (const PathFinding* path = advance_->path()) {
    record_.unstable_modes = path->unstable_modes;
    record_.critical = path->critical;
  }
  measure_contact();
  follow_turns(model_.constraints().joints(), q_.get(), v_.get());
  advance_->accept(attempt);
  record_.z = advance_->state().z;
  constexpr double rounding = 1e-6;
  if (analysis_ != Analysis::dynamic && is_as_planned && moved_ > rounding * moved_in_all_) {
    moved_in_all_ += moved_;
    grown_ += record_.dt;
    last_growth_ = moved_ / record_.dt;
  }
  steps_.shortest = steps_.accepted == 0 ? record_.dt : std::min(steps_.shortest, record_.dt);
  steps_.longest = std::max(steps_.longest, record_.dt);
  ++steps_.accepted;
}

}  // namespace pliant
