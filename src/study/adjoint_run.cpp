#include "study/adjoint_run.hpp"

#include "fem/element.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "solver/merit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Memory for steps on each rank, unless the user says how many [bytes].
constexpr double usual_memory = 1024.0 * 1024.0 * 1024.0;
/// How far a time of the weights may be from that of a step, in lengths of the step.
constexpr double same_time = 1e-6;
/// Relative residual of linear systems of which a part has no matrix.
constexpr double relative_residual = 1e-10;

std::size_t most_stages(const Config& config) {
  const Method* method = integrator_of(config);
  constexpr std::size_t of_start = 3;  // of dirk33
  return std::max(of_start, method != nullptr ? method->bt.size() : 1);
}

Handle<Vec> duplicate(Vec like) {
  Handle<Vec> x;
  if (like == nullptr) return x;
  check(VecDuplicate(like, x.out()));
  check(VecZeroEntries(x.get()));
  return x;
}

/// 1 for the internal variables of the cells that this rank owns, else 0.
Handle<Vec> ownership(const Model& model, const IncrementalPotential& potential, Vec like) {
  Handle<Vec> owned = duplicate(like);
  if (!owned) return owned;
  const std::vector<PetscInt> cells = cells_of_internal(potential);
  const ArrayView flags(owned.get());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] < model.layout().num_owned_cells) flags.span()[i] = 1.0;
  }
  return owned;
}

}  // namespace

AdjointRun::AdjointRun(const Mesh& mesh, Config config, AdjointWeights weights,
                       const std::vector<Parameter>& parameters, std::int64_t kept_steps)
    : config_(std::move(config)), model_(mesh, config_), kept_steps_(kept_steps), weights_(std::move(weights)) {
  require_adjoint();
  simulation_.emplace(config_, model_);
  recording_.emplace(*simulation_);
  seeds_ = seeds_of(weights_, config_, HistoryRow(config_, model_, simulation_->ledger()).columns());
  for (const Parameter& p : parameters) {
    pairs_.push_back(std::make_unique<AdjointPair>(mesh, model_.layout(), p));
  }
  for (Handle<Vec>* x : {&start_.q, &start_.v, &lambda_, &rhs_, &unknowns_, &algebraic_q_, &algebraic_q0_, &unused_,
                         &seed_, &by_displacement_, &by_velocity_, &by_position_}) {
    *x = make_vector(model_.layout());
  }
  const Vec z = simulation_->record().z;
  for (Handle<Vec>* x : {&start_.z, &owned_, &zero_z_}) *x = duplicate(z);
  owned_z_ = ownership(model_, model_.potential(), z);
  const std::size_t stages = most_stages(config_);
  q_.emplace(stages, start_.q.get());
  v_.emplace(stages, start_.q.get());
  if (z != nullptr) z_.emplace(stages, z);
  whole_ = std::make_unique<OperatorSystem>(lambda_.get());
}

void AdjointRun::require_adjoint() {
  const auto refuse = [&](const Location& where, const std::string& what) {
    throw InputError(where, what + "; derivatives by few numbers do (`--of` instead of `--adjoint`)");
  };
  const Location file{config_.file, 0, 0};
  if (config_.time.path) {
    throw InputError(config_.time.path->where,
                     "derivatives along a path are not defined where its load factor turns back; remove 'path'");
  }
  if (analysis_of(config_) != Analysis::static_equilibrium && integrator_of(config_) == nullptr) {
    throw InputError(config_.time.method.where, "an adjoint needs one of Pliant's own methods, not one of PETSc's");
  }
  if (model_.mixed_equation() != nullptr) refuse(file, "bodies with 'volumetric: mixed' have no adjoint");
  if (model_.constraints().map() != nullptr) {
    refuse(file, "rigid bodies, and constraints that join the displacements of nodes, have no adjoint");
  }
  const std::vector<std::string> missing = model_.potential().adjoint().missing();
  if (missing.empty()) return;
  refuse(file, fmt::format("the input has what has no adjoint: {}", fmt::join(missing, ", ")));
}

void AdjointRun::begin_segment() {
  // What a solver has learned would make the repeated steps differ in the last digits.
  if (!segments_.empty()) simulation_->forget();
  segments_.push_back({simulation_->record().step, StateInMemory(*simulation_)});
  recording_->clear();
}

void AdjointRun::advance(const std::function<void(double)>& progress) {
  const StepOutcome outcome = simulation_->complete_step();
  if (outcome.is_input_error) throw InputError({config_.file, 0, 0}, outcome.reason);
  if (outcome.kind == StepOutcome::Kind::failed) throw SolveError(outcome.reason);
  times_[simulation_->record().step] = simulation_->record().time;
  progress(simulation_->record().time);
}

void AdjointRun::run(const std::function<void(double)>& progress) {
  times_[0] = simulation_->record().time;
  begin_segment();
  while (!simulation_->finished()) {
    advance(progress);
    if (kept_steps_ == 0) {
      const double bytes = maximum(model_.layout().comm, recording_->bytes_per_step());
      kept_steps_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(usual_memory / std::max(bytes, 1.0)));
    }
    const bool is_full = static_cast<std::int64_t>(recording_->steps().size()) >= kept_steps_;
    if (is_full && !simulation_->finished()) begin_segment();
  }
}

void AdjointRun::find_steps_of_weights() {
  for (std::size_t n = 0; n < weights_.times.size(); ++n) {
    const auto at = std::ranges::min_element(
        times_, {}, [&](const auto& step) { return std::abs(step.second - weights_.times[n]); });
    const auto next = at->first > 0 ? times_.at(at->first - 1) : times_.rbegin()->second;
    if (std::abs(at->second - weights_.times[n]) > same_time * std::abs(at->second - next)) {
      throw InputError({weights_.file, weights_.lines[n], 1},
                       fmt::format("no step ends at {:.9g}; the nearest is at {:.9g}: times are those of history.csv",
                                   weights_.times[n], at->second));
    }
    std::vector<double>& sum = weights_of_step_[at->first];
    sum.resize(seeds_.size());
    for (std::size_t c = 0; c < seeds_.size(); ++c) sum[c] += weights_.rows[n][c];
  }
}

void AdjointRun::go_back(const std::function<void(double)>& progress) {
  find_steps_of_weights();
  const std::int64_t num_steps = this->num_steps();
  for (std::size_t s = segments_.size(); s-- > 0;) {
    const std::int64_t end = s + 1 < segments_.size() ? segments_[s + 1].first : num_steps;
    if (s + 1 < segments_.size()) {
      segments_[s].state.restore(*simulation_);
      simulation_->forget();
      recording_->clear();
      while (simulation_->record().step < end) {
        advance(progress);
        ++num_repeated_;
      }
    }
    for (auto step = recording_->steps().rbegin(); step != recording_->steps().rend(); ++step) {
      go_back_through(*step);
      progress(step->step.time);
    }
  }
  go_back_to_start();
}

AdjointRun::Bars& AdjointRun::bars_of(std::int64_t step) {
  Bars& bars = bars_[step];
  if (!bars.q) {
    bars.q = make_vector(model_.layout());
    bars.v = make_vector(model_.layout());
    bars.z = duplicate(start_.z.get());
  }
  return bars;
}

void AdjointRun::add_to_position(const ProbeLocation& probe, int component, double weight) {
  const GhostedView position(by_position_.get());
  const auto add = [&](PetscInt node, double part) {
    position.span()[static_cast<std::size_t>(3 * node + component)] += weight * part;
  };
  for (std::size_t a = 0; a < probe.nodes.size(); ++a) {
    if (a < 4) {
      add(probe.nodes[a], probe.weights[a]);
      continue;
    }
    for (const int corner : tet_edges[a - 4])
      add(probe.nodes[static_cast<std::size_t>(corner)], 0.5 * probe.weights[a]);
  }
}

void AdjointRun::add_weights(std::int64_t step, Bars& bars) {
  const auto found = weights_of_step_.find(step);
  if (found == weights_of_step_.end()) return;
  for (const bool is_velocity : {false, true}) {
    {
      const GhostedView seed(seed_.get());
      std::ranges::fill(seed.span(), 0.0);
      for (std::size_t c = 0; c < seeds_.size(); ++c) {
        if (seeds_[c].is_velocity != is_velocity) continue;
        const ProbeLocation& probe = model_.probes()[seeds_[c].probe];
        if (!is_velocity) add_to_position(probe, seeds_[c].component, found->second[c]);
        for (std::size_t a = 0; a < probe.nodes.size(); ++a) {
          const auto entry = static_cast<std::size_t>(3 * probe.nodes[a] + seeds_[c].component);
          seed.span()[entry] += found->second[c] * probe.weights[a];
        }
      }
    }
    check(VecGhostUpdateBegin(seed_.get(), ADD_VALUES, SCATTER_REVERSE));
    check(VecGhostUpdateEnd(seed_.get(), ADD_VALUES, SCATTER_REVERSE));
    check(VecAXPY(is_velocity ? bars.v.get() : bars.q.get(), 1.0, seed_.get()));
  }
}

void AdjointRun::clear_prescribed(Vec x) const {
  const std::vector<char>& flags = model_.constraints().prescribed().flags();
  const ArrayView entries(x);
  for (std::size_t i = 0; i < entries.span().size(); ++i) {
    if (flags[i]) entries.span()[i] = 0.0;
  }
}

void AdjointRun::go_back_through(const RecordedStep& step) {
  Bars bars = std::move(bars_of(step.number));
  bars_.erase(step.number);
  if (step.restarts) {
    for (const auto& pair : pairs_) pair->add_restart(step.step, bars.v.get());
    clear_prescribed(bars.v.get());
  }
  add_weights(step.number, bars);
  if (step.method == nullptr) {
    const RecordedStage& stage = step.stages.back();
    check(VecZeroEntries(algebraic_q0_.get()));
    check(VecCopy(bars.q.get(), algebraic_q_.get()));
    solve(stage, bars.q.get());
    add_to_parameters(stage, nullptr);
    return;
  }
  const Method& method = *step.method;
  for (const auto& pair : pairs_) pair->add_completion(step.end(), owned_part(bars.z.get()));
  model_.potential().adjoint().pull_back_completion(step.end(), bars.z.get(), bars.q.get());
  for (const auto& pair : pairs_) pair->add_end(step.step, bars.q.get(), bars.v.get());
  clear_prescribed(bars.q.get());
  clear_prescribed(bars.v.get());
  q_->begin(method, bars.q.get());
  v_->begin(method, bars.v.get());
  if (z_) z_->begin(method, bars.z.get());
  for (std::size_t i = step.stages.size(); i-- > 0;) {
    go_back_through(step.stages[i], q_->stage(i), v_->stage(i), z_ ? z_->stage(i) : nullptr);
    q_->start_stage(method, i, start_.q.get());
    v_->start_stage(method, i, start_.v.get());
    if (z_) z_->start_stage(method, i, start_.z.get());
  }
  const auto alpha = step.weights.alpha();
  for (std::size_t r = 0; r < alpha.size(); ++r) {
    Bars& past = bars_of(step.number - 1 - static_cast<std::int64_t>(r));
    check(VecAXPY(past.q.get(), alpha[r], q_->base()));
    check(VecAXPY(past.v.get(), alpha[r], v_->base()));
    if (z_) check(VecAXPY(past.z.get(), alpha[r], z_->base()));
  }
}

void AdjointRun::go_back_through(const RecordedStage& stage, Vec q, Vec v, Vec z) {
  for (const Handle<Vec>* x : {&start_.q, &start_.v, &start_.z}) {
    if (*x) check(VecZeroEntries(x->get()));
  }
  // v_i = (q_i - q_i0) / dt_i
  check(VecAXPY(q, 1.0 / stage.point.dt, v));
  check(VecAXPY(start_.q.get(), -1.0 / stage.point.dt, v));
  check(VecCopy(q, algebraic_q_.get()));
  check(VecCopy(start_.q.get(), algebraic_q0_.get()));
  StageAdjoint adjoint = model_.potential().adjoint();
  if (z != nullptr) {
    model_.potential().begin_stage(stage.point);
    check(VecZeroEntries(lambda_.get()));
    adjoint.pull_back(stage.q.get(), lambda_.get(), z, {q, start_.q.get(), start_.v.get(), start_.z.get()});
  }
  solve(stage, q);
  adjoint.pull_back(stage.q.get(), lambda_.get(), zero_z_.get(),
                    {unused_.get(), start_.q.get(), start_.v.get(), start_.z.get()});
  add_to_parameters(stage, z);
  clear_prescribed(start_.q.get());
  clear_prescribed(start_.v.get());
}

void AdjointRun::solve(const RecordedStage& stage, Vec b) {
  StageEquation& equation = model_.equation();
  equation.enter(stage.point, stage.q.get(), unknowns_.get());
  equation.freeze(unknowns_.get());
  check(VecCopy(b, rhs_.get()));
  check(VecScale(rhs_.get(), -1.0));
  clear_prescribed(rhs_.get());
  check(VecZeroEntries(lambda_.get()));
  if (norm(rhs_.get()) == 0.0) return;
  TangentSystem& system = recording_->solver()->tangent();
  StageAdjoint adjoint = model_.potential().adjoint();
  const auto product = [&](Vec x, Vec y) {
    system.multiply(x, y);
    adjoint.add_transposed_rest(unknowns_.get(), x, y);
    clear_prescribed(y);
  };
  bool works = system.begin(unknowns_.get());
  const auto inverse = [&](Vec x, Vec y) { works = works && system.solve(x, y); };
  // Solved again for what is left: the errors of all stages add up.
  const Vec left = seed_.get(), part = unused_.get();
  check(VecCopy(rhs_.get(), left));
  for (int round = 0; round < 2 && works && norm(left) > 0.0; ++round) {
    if (adjoint.has_rest()) {
      works = whole_->solve(product, inverse, left, part, relative_residual) && works;
    } else {
      inverse(left, part);
    }
    check(VecAXPY(lambda_.get(), 1.0, part));
    product(lambda_.get(), left);
    check(VecAYPX(left, -1.0, rhs_.get()));
  }
  system.end();
  if (!works) {
    throw SolveError(
        fmt::format("the adjoint cannot be computed at t = {:.6g}: its linear system has no solution; the "
                    "run is at a point where it may continue in several ways",
                    stage.point.time));
  }
  clear_prescribed(lambda_.get());
}

Vec AdjointRun::owned_part(Vec z) {
  if (z == nullptr) return nullptr;
  check(VecPointwiseMult(owned_.get(), z, owned_z_.get()));
  return owned_.get();
}

void AdjointRun::add_to_parameters(const RecordedStage& stage, Vec internal) {
  const StageBars bars{lambda_.get(), algebraic_q_.get(), algebraic_q0_.get(), owned_part(internal)};
  for (const auto& pair : pairs_) pair->add_stage(stage, bars);
}

void AdjointRun::go_back_to_start() {
  Bars bars = std::move(bars_of(0));
  bars_.clear();
  add_weights(0, bars);
  check(VecGhostUpdateBegin(by_position_.get(), ADD_VALUES, SCATTER_REVERSE));
  check(VecGhostUpdateEnd(by_position_.get(), ADD_VALUES, SCATTER_REVERSE));
  if (simulation_->analysis() == Analysis::static_equilibrium) return;
  segments_.front().state.restore(*simulation_);
  for (const auto& pair : pairs_) pair->add_completion(simulation_->record().q, owned_part(bars.z.get()));
  model_.potential().adjoint().pull_back_completion(simulation_->record().q, bars.z.get(), bars.q.get());
  for (const auto& pair : pairs_) pair->add_start(bars.q.get(), bars.v.get());
  for (const Vec x : {bars.q.get(), bars.v.get()}) clear_prescribed(x);
  check(VecCopy(bars.q.get(), by_displacement_.get()));
  check(VecCopy(bars.v.get(), by_velocity_.get()));
}

}  // namespace pliant
