#include "study/tangent_run.hpp"

#include "model/mesh_source.hpp"
#include "petsc/array_view.hpp"
#include "solver/merit.hpp"
#include "study/neighbours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// What is left of the right-hand side of linear systems.
constexpr double part_that_is_left = 1e-9;
/// Relative residual of linear systems whose products are differences.
constexpr double relative_residual = 1e-6;
/// They are solved again for what is left until it moves the solution by no more than this part of the first time.
constexpr int most_rounds = 8;
constexpr double settled = 1e-8, nearly_settled = 1e-4;
/// Differences of residuals below this many times the floor of one may be rounding.
constexpr double noise = 1e3;
/// Along which part of the change that the matrix alone would make the first differences are taken.
constexpr double cautious = 0.01;
/// Rounds that leave more than this part of the residual have taken differences over too large a change.
constexpr double slow = 0.1;

/// Copies what x has in addition to displacements.
void copy_extra_unknowns(const NodeLayout& layout, Vec from, Vec to) {
  const ConstArrayView source(from);
  const ArrayView target(to);
  const auto first = 3 * static_cast<std::size_t>(layout.num_owned_nodes);
  for (std::size_t i = first; i < source.span().size(); ++i) target.span()[i] = source.span()[i];
}

/// Whether the columns are functions of places and velocities alone.
bool are_of_probes(std::span<const std::string> columns, const Config& config) {
  constexpr std::array suffixes{"_x", "_y", "_z", "_vx", "_vy", "_vz", "_ux", "_uy", "_uz"};
  return std::ranges::all_of(columns, [&](const std::string& column) {
    return std::ranges::any_of(config.probes, [&](const auto& probe) {
      return std::ranges::any_of(suffixes, [&](const char* suffix) { return column == probe.name + suffix; });
    });
  });
}

}  // namespace

/// The run of another value, with the solutions of the run in the middle.
struct TangentRun::Neighbour {
  Neighbour(const Mesh& mesh, Config given, const NodeLayout& layout, Books books)
      : config(std::move(given)),
        model(mesh, config, layout),
        simulation(config, model, Stages::solved_elsewhere, books),
        row(config, model, simulation.ledger()),
        unknowns(model.equation().make_vector()),
        residual(model.equation().make_vector()) {}

  /// Begins the stage at the solution of the other run.
  void start_stage(Vec q, Vec solution) {
    const StagePoint& stage = simulation.start_stage(q);
    StageEquation& equation = model.equation();
    equation.enter(stage, simulation.unknown(), unknowns.get());
    copy_extra_unknowns(model.layout(), solution, unknowns.get());
  }
  /// Brings coefficients and the residual to the unknowns.
  void measure(Coefficients coefficients) {
    StageEquation& equation = model.equation();
    equation.freeze(unknowns.get());
    // That of the run may have exceeded its bound on the way to the solution, where none of these does.
    if (coefficients == Coefficients::follow_beyond_bound) equation.exceed_bound();
    if (coefficients != Coefficients::frozen) equation.refreeze(unknowns.get());
    equation.gradient(unknowns.get(), residual.get());
  }
  void end_stage() {
    model.equation().leave(unknowns.get(), simulation.unknown());
    simulation.end_stage();
  }
  std::vector<double> values() { return row.values(simulation.record(), simulation.ledger()); }

  Config config;
  Model model;
  Simulation simulation;
  HistoryRow row;
  Handle<Vec> unknowns, residual;
};

struct TangentRun::Pair {
  /// r = half the difference of the residuals.
  void measure(Coefficients coefficients, Vec r) {
    for (Neighbour* run : {below.get(), above.get()}) run->measure(coefficients);
    check(VecWAXPY(r, -1.0, below->residual.get(), above->residual.get()));
    check(VecScale(r, 0.5));
  }
  /// Moves the unknowns by -d above and d below.
  void move(Vec d) {
    check(VecAXPY(above->unknowns.get(), -1.0, d));
    check(VecAXPY(below->unknowns.get(), 1.0, d));
  }

  std::unique_ptr<Neighbour> below, above;
  double spacing = 0.0;
  StageExtrapolation solutions;
  Handle<Vec> residual, solution, change;
};

TangentRun::TangentRun(const Mesh& mesh, const VariedInput& input, std::span<const double> values,
                       std::span<const std::string> wanted, std::span<const double> sizes)
    : config_(input.at(values)), model_(mesh, config_), wanted_(wanted.begin(), wanted.end()) {
  if (config_.time.path) {
    throw InputError(config_.time.path->where,
                     "derivatives along a path are not defined where its load factor turns back; remove 'path'");
  }
  if (analysis_of(config_) != Analysis::static_equilibrium && integrator_of(config_) == nullptr) {
    throw InputError(config_.time.method.where, "derivatives need one of Pliant's own methods, not one of PETSc's");
  }
  simulation_.emplace(config_, model_);
  row_.emplace(config_, model_, simulation_->ledger());
  for (Handle<Vec>* v : {&r_, &change_, &scaled_}) *v = model_.equation().make_vector();
  whole_ = std::make_unique<OperatorSystem>(r_.get());
  for (std::size_t n = 0; n < values.size(); ++n) add_pair(mesh, input, values, n, sizes.empty() ? 0.0 : sizes[n]);
  slopes_.resize(pairs_.size());
  simulation_->follow(*this);
  measure();
}

TangentRun::~TangentRun() = default;

void TangentRun::add_pair(const Mesh& mesh, const VariedInput& input, std::span<const double> values, std::size_t n,
                          double size) {
  const double value = values[n];
  if (value != 0.0) size = size_of_number(input.numbers()[n].key, value);
  if (size == 0.0) throw without_neighbours(input.file(), input.numbers()[n].key);
  std::vector<double> changed(values.begin(), values.end());
  const Books books = are_of_probes(wanted_, config_) ? Books::none : Books::kept;
  auto [below, above, spacing] = neighbours_of(value, size, [&](double other) {
    changed[n] = other;
    return std::make_unique<Neighbour>(mesh, input.at(changed), model_.layout(), books);
  });
  Pair pair{std::move(below), std::move(above), spacing, StageExtrapolation(r_.get()), {}, {}, {}};
  for (Handle<Vec>* x : {&pair.residual, &pair.solution, &pair.change}) *x = model_.equation().make_vector();
  pairs_.push_back(std::move(pair));
}

void TangentRun::advance() {
  const StepOutcome outcome = simulation_->complete_step();
  if (outcome.is_input_error) throw InputError({config_.file, 0, 0}, outcome.reason);
  if (outcome.kind == StepOutcome::Kind::failed) throw SolveError(outcome.reason);
  measure();
}

void TangentRun::begin_step(const Step& step) {
  for (Pair& pair : pairs_) {
    for (Neighbour* run : {pair.below.get(), pair.above.get()}) run->simulation.begin(step);
  }
}

void TangentRun::end_stage(NewtonSolver& solver, const StagePoint& stage, Vec q) {
  const Vec solution = solver.unknowns();
  StageEquation& equation = solver.equation();
  const Coefficients coefficients = !equation.refreeze(solution) ? Coefficients::frozen
                                    : equation.exceeds_bound()   ? Coefficients::follow_beyond_bound
                                                                 : Coefficients::follow;
  // The Hessian of a potential is that of all its forces.
  const bool is_whole = equation.is_potential() && coefficients == Coefficients::frozen;
  TangentSystem& system = solver.tangent();
  const auto require = [&](bool works) {
    if (works) return;
    throw SolveError(
        fmt::format("the derivatives cannot be computed at t = {:.6g}: their linear system has no solution; "
                    "the run is at a point where it may continue in several ways",
                    time()));
  };
  require(system.begin(solution));
  const double floor = equation.rounding_floor(solution);
  for (Pair& pair : pairs_) {
    for (Neighbour* run : {pair.below.get(), pair.above.get()}) run->start_stage(q, solution);
    if (!is_whole) require(solve(pair, system, {coefficients, floor}));
  }
  // Time stands still in static problems.
  if (is_whole) require(solve(system, stage.time + stage.load_factor, floor));
  system.end();
  for (Pair& pair : pairs_) {
    // Frozen forces are those of the last trial.
    if (coefficients != Coefficients::frozen) pair.measure(coefficients, r_.get());
    for (Neighbour* run : {pair.below.get(), pair.above.get()}) run->end_stage();
  }
}

bool TangentRun::solve(TangentSystem& system, double place, double floor) {
  std::vector<Vec> residuals, guesses, changes;
  std::vector<Pair*> open;
  for (Pair& pair : pairs_) {
    const Vec guess = pair.solution.get(), r = pair.residual.get();
    const bool has_guess = pair.solutions.guess(place, guess);
    if (has_guess) pair.move(guess);
    pair.measure(Coefficients::frozen, r);
    const double size = norm(r);
    if (!std::isfinite(size)) return false;
    if (size <= floor) continue;
    residuals.push_back(r);
    guesses.push_back(has_guess ? guess : nullptr);
    changes.push_back(pair.change.get());
    open.push_back(&pair);
  }
  if (!system.solve(residuals, guesses, changes, part_that_is_left)) return false;
  for (Pair* pair : open) {
    pair->move(pair->change.get());
    check(VecAXPY(pair->solution.get(), 1.0, pair->change.get()));
  }
  for (Pair& pair : pairs_) pair.solutions.take(place, pair.solution.get());
  return true;
}

bool TangentRun::solve(Pair& pair, TangentSystem& system, const StageTangent& stage) {
  double first = 0.0, last = 0.0, size = 0.0, before = 0.0;
  for (int round = 0; round < most_rounds; ++round) {
    pair.measure(stage.coefficients, r_.get());
    if (!std::isfinite(norm(r_.get()))) return false;
    const bool is_rounding = norm(r_.get()) <= stage.floor;
    if (is_rounding && round > 0) return true;
    if (!system.solve(r_.get(), change_.get())) return false;
    if (norm(change_.get()) == 0.0) return true;
    // Without what the matrix leaves out the change may be far too large. A difference over all of it may reach beyond
    // a kink, as that of friction between sliding and sticking, on whose near side the solution is.
    const double left = norm(r_.get());
    if (round <= 1) size = round == 0 ? cautious * norm(change_.get()) : first;
    if (round > 1 && left > slow * before) size = last;
    before = left;
    bool needs_more = !is_rounding;
    if (needs_more && !solve_for_whole(pair, stage.coefficients, system, size)) {
      // Where the number has next to no influence, the difference is all rounding, and no system resolves it.
      if (norm(r_.get()) > noise * stage.floor || !system.solve(r_.get(), change_.get())) return false;
      needs_more = false;
    }
    pair.move(change_.get());
    last = norm(change_.get());
    if (round == 0) first = last;
    if (!needs_more || last <= settled * first) return true;
  }
  return last <= nearly_settled * first || norm(r_.get()) <= noise * stage.floor;
}

bool TangentRun::solve_for_whole(Pair& pair, Coefficients coefficients, TangentSystem& system, double size) {
  const auto product = [&](Vec x, Vec y) {
    const double factor = size / norm(x);
    check(VecCopy(x, scaled_.get()));
    check(VecScale(scaled_.get(), -factor));
    pair.move(scaled_.get());
    pair.measure(coefficients, y);
    check(VecScale(scaled_.get(), -1.0));
    pair.move(scaled_.get());
    check(VecAXPY(y, -1.0, r_.get()));
    check(VecScale(y, 1.0 / factor));
  };
  bool works = true;
  const auto inverse = [&](Vec x, Vec y) { works = system.solve(x, y) && works; };
  return whole_->solve(product, inverse, r_.get(), change_.get(), relative_residual) && works;
}

void TangentRun::end_step(bool restarts) {
  for (Pair& pair : pairs_) {
    for (Neighbour* run : {pair.below.get(), pair.above.get()}) run->simulation.end_step(restarts);
  }
}

void TangentRun::measure() {
  values_ = row_->values(simulation_->record(), simulation_->ledger());
  for (std::size_t n = 0; n < pairs_.size(); ++n) {
    const std::vector<double> below = pairs_[n].below->values(), above = pairs_[n].above->values();
    slopes_[n].resize(values_.size());
    for (std::size_t c = 0; c < values_.size(); ++c) {
      const bool is_wanted = std::ranges::find(wanted_, columns()[c]) != wanted_.end();
      slopes_[n][c] = is_wanted ? (above[c] - below[c]) / pairs_[n].spacing : std::numeric_limits<double>::quiet_NaN();
    }
  }
}

Mesh mesh_of(MPI_Comm comm, const VariedInput& input) {
  return read_mesh(comm, mesh_source(input.given()));
}

}  // namespace pliant
