#include "energy/equation/incremental_potential.hpp"

#include "energy/function_of_sum.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "fem/components.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// How far frozen coefficients may exceed their bound: by the change from step to step in steady sliding.
constexpr double drag_excess = 1e-3;

}  // namespace

IncrementalPotential::IncrementalPotential(const NodeLayout& layout, const BlockPattern& pattern,
                                           std::vector<const EnergyTerm*> terms, const std::vector<char>& prescribed)
    : layout_(layout),
      pattern_(pattern),
      prescribed_(prescribed),
      elimination_(layout, pattern, prescribed_),
      terms_(layout, std::move(terms), prescribed_) {
  if (!terms_.pair_terms().empty()) of_cells_ = make_matrix(layout, pattern);
  free_bodies_ = free_components(layout, [&](PetscInt node) {
    return prescribed_[3 * node] || prescribed_[3 * node + 1] || prescribed_[3 * node + 2];
  });
  for (Handle<Vec>* v : {&work_, &diagonal_}) *v = pliant::make_vector(layout);
}

void IncrementalPotential::clear_prescribed(std::span<double> r) const {
  for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
    if (prescribed_[i]) r[i] = 0.0;
  }
}

void IncrementalPotential::begin_stage(const StagePoint& stage) {
  terms_.begin(stage);
  terms_.arrays().stage().exceeds_bound = exceeds_bound_;
}

StagePoint IncrementalPotential::enter(const StagePoint& stage, Vec q, Vec xi) {
  begin_stage(stage);
  check(VecCopy(q, xi));
  return stage;
}

void IncrementalPotential::freeze(Vec q) {
  exceeds_bound_ = terms_.arrays().stage().exceeds_bound = false;
  const auto needs_it = [](const EnergyTerm* term) {
    return term->declaration().refreezes || term->declaration().has_frozen_coefficients;
  };
  if (std::ranges::any_of(terms_.all(), needs_it)) terms_.arrays().freeze(q);
}

bool IncrementalPotential::refreeze(Vec q) {
  exceeds_bound_ = terms_.arrays().stage().exceeds_bound = exceeds_bound_ || exceeds_a_bound(q);
  const auto refreezes = [](const EnergyTerm* term) { return term->declaration().refreezes; };
  if (!exceeds_bound_ && std::ranges::none_of(terms_.all(), refreezes)) return false;
  terms_.arrays().freeze(q);
  return true;
}

void IncrementalPotential::exceed_bound() {
  exceeds_bound_ = terms_.arrays().stage().exceeds_bound = true;
}

void IncrementalPotential::drag(Vec q, Vec at, Vec f) {
  terms_.arrays().freeze(at);
  gradient_of(
      [&](const EnergyTerm& term) {
        const TermDeclaration is = term.declaration();
        return is.refreezes || (exceeds_bound_ && is.has_frozen_coefficients);
      },
      q, f);
  const ArrayView rows(f);
  clear_prescribed(rows.span());
}

bool IncrementalPotential::exceeds_a_bound(Vec q) {
  const auto has_bound = [](const EnergyTerm* term) { return term->declaration().has_frozen_coefficients; };
  if (std::ranges::none_of(terms_.all(), has_bound)) return false;
  const auto at = terms_.at(q);
  std::vector<double> sums;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (!has_bound(&terms_[k])) continue;
    const DragBound bound = terms_[k].bound(terms_.stage_of(k), at);
    sums.insert(sums.end(), {bound.exerted, bound.allowed});
  }
  sum_in_place(layout_.comm, sums);
  for (std::size_t i = 0; i < sums.size(); i += 2) {
    if (sums[i] > (1.0 + drag_excess) * sums[i + 1]) return true;
  }
  return false;
}

double IncrementalPotential::value(Vec q) {
  const auto at = terms_.at(q);
  double mine = 0.0;
  for (std::size_t k = 0; k < terms_.size(); ++k) mine += terms_[k].value(terms_.stage_of(k), at);
  double total = sum(layout_.comm, mine);
  for (const std::size_t k : terms_.functions_of_sum())
    total += terms_.function_of_sum(k).value_of_sum(terms_.stage_of(k));
  return std::isfinite(total) ? total : std::numeric_limits<double>::infinity();
}

void IncrementalPotential::take_owned(std::span<const double> rows, Vec r) const {
  const ArrayView owned(r);
  std::copy_n(rows.begin(), 3 * layout_.num_owned_nodes, owned.span().begin());
}

void IncrementalPotential::gradient_of(const std::function<bool(const EnergyTerm&)>& wanted, Vec q, Vec r) {
  const auto at = terms_.at(q);
  const auto rows = terms_.empty_rows();
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (wanted(terms_[k])) terms_[k].add_gradient(terms_.stage_of(k), at, rows);
  }
  take_owned(rows, r);
}

void IncrementalPotential::gradient_with_reactions(Vec q, Vec r) {
  gradient_of([](const EnergyTerm&) { return true; }, q, r);
}

void IncrementalPotential::gradient(Vec q, Vec r) {
  gradient_with_reactions(q, r);
  const ArrayView rows(r);
  clear_prescribed(rows.span());
}

double IncrementalPotential::force_of(std::size_t k, std::span<const double> q) {
  const auto rows = terms_.empty_rows();
  terms_[k].add_gradient(terms_.stage_of(k), q, rows);
  take_owned(rows, work_.get());
  PetscReal norm = 0.0;
  check(VecNorm(work_.get(), NORM_2, &norm));
  return norm;
}

double IncrementalPotential::force_scale(Vec q) {
  const auto at = terms_.at(q);
  double scale = 0.0;
  for (std::size_t k = 0; k < terms_.size(); ++k) scale += force_of(k, at);
  return scale;
}

double IncrementalPotential::inertia_scale() {
  double scale = 0.0;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (terms_[k].declaration().account == Account::kinetic) scale += force_of(k, terms_.arrays().stage().q0);
  }
  return scale;
}

bool IncrementalPotential::is_static() const {
  return std::ranges::none_of(terms_.all(),
                              [](const EnergyTerm* term) { return term->declaration().account == Account::kinetic; });
}

void IncrementalPotential::hessian(Vec q, Mat K, Projection projection) {
  const auto at = terms_.at(q);
  const auto of_term = [&](std::size_t k) {
    if (projection != Projection::walls) return projection;
    return terms_[k].declaration().is_wall ? Projection::positive_semidefinite : Projection::none;
  };
  if (terms_.arrays().pairs() != nullptr) fit(K);
  const PairAssembly* pairs = terms_.arrays().pairs();
  Mat of_cells = pairs != nullptr ? of_cells_.get() : K;
  {
    BlockWriter writer(pattern_, of_cells);
    std::size_t first = 0;  // a term that the matrix starts from
    while (first < terms_.size() && !terms_[first].set_hessian(terms_.stage_of(first), writer)) ++first;
    if (first == terms_.size()) writer.zero();
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      if (k != first && terms_.near(k) == nullptr) terms_[k].add_hessian(terms_.stage_of(k), at, writer, of_term(k));
    }
    if (pairs == nullptr) writer.copy_diagonal(ArrayView(diagonal_.get()).span());
    writer.finish();
  }
  if (pairs != nullptr) {
    BlockWriter writer(pairs->pattern(), K);
    writer.zero();
    writer.add(pattern_, of_cells);
    for (const std::size_t k : terms_.pair_terms()) terms_[k].add_hessian(terms_.stage_of(k), at, writer, of_term(k));
    writer.copy_diagonal(ArrayView(diagonal_.get()).span());
    writer.finish();
  }
  PetscReal total = 0.0;
  check(VecNorm(diagonal_.get(), NORM_1, &total));
  BlockWriter writer(pairs != nullptr ? pairs->pattern() : pattern_, K);
  const RowElimination& elimination = pairs != nullptr ? pairs->elimination() : elimination_;
  elimination.apply(writer, total > 0.0 ? total / (3.0 * layout_.num_global_nodes) : 1.0);
  writer.finish();
}

void IncrementalPotential::fit(Mat K) {
  if (terms_.arrays().pairs()->fit()) present_pattern_.change();
  if (!present_pattern_.is_that_of(K)) present_pattern_.give(K, make_hessian_of(terms_.arrays().pairs()->pattern()));
}

void IncrementalPotential::forget() {
  if (terms_.arrays().pairs() == nullptr) return;
  terms_.arrays().pairs()->forget();
  present_pattern_.change();
}

void IncrementalPotential::rank_one_parts(Vec q, std::vector<RankOne>& parts) {
  const auto at = terms_.at(q);
  sum_rounding_ = 0.0;
  for (std::size_t i = 0; i < terms_.functions_of_sum().size(); ++i) {
    const std::size_t k = terms_.functions_of_sum()[i];
    const FunctionOfSum& function = terms_.function_of_sum(k);
    auto& [c, g] = parts[i];
    c = function.curvature(terms_.stage_of(k));
    double size = 0.0;
    const auto rows = terms_.empty_rows();
    function.add_gradient_of_sum(terms_.stage_of(k), at, rows);
    clear_prescribed(rows);
    for (PetscInt e = 0; e < 3 * layout_.num_owned_nodes; ++e) size += std::abs(rows[e] * at[e]);
    take_owned(rows, g.get());
    PetscReal norm = 0.0;
    check(VecNorm(g.get(), NORM_2, &norm));
    sum_rounding_ += std::numeric_limits<double>::epsilon() * c * norm * sum(layout_.comm, size);
  }
}

Handle<Mat> IncrementalPotential::make_hessian() const {
  return make_hessian_of(pattern_);
}

Handle<Mat> IncrementalPotential::make_hessian_of(const BlockPattern& pattern) const {
  Handle<Mat> K = make_matrix(layout_, pattern);
  if (!is_symmetric(symmetry())) {
    check(MatSetOption(K.get(), MAT_SYMMETRY_ETERNAL, PETSC_FALSE));
    check(MatSetOption(K.get(), MAT_SYMMETRIC, PETSC_FALSE));
    check(MatSetOption(K.get(), MAT_STRUCTURALLY_SYMMETRIC, PETSC_TRUE));
  }
  set_near_null_modes(K.get(), rigid_body_modes(layout_, prescribed_));
  return K;
}

void IncrementalPotential::follow_rigid_motions(Vec q, Mat K) const {
  const ConstArrayView displacements(q);
  set_near_null_modes(K, rigid_body_modes(layout_, prescribed_, displacements));
}

std::optional<Coarsening> IncrementalPotential::make_coarsening() const {
  if (layout_.order == 1) return std::nullopt;
  return pliant::make_coarsening(layout_, prescribed_);
}

std::unique_ptr<NodalRotations> IncrementalPotential::make_rotations() const {
  if (std::ranges::any_of(terms_.all(), [](const EnergyTerm* term) { return !term->declaration().rotates_with_body; }))
    return nullptr;
  return std::make_unique<NodalRotations>(layout_, prescribed_);
}

double IncrementalPotential::step_bound(std::size_t k, const Path& path) {
  const LocalStage& stage = terms_.stage_of(k);
  const double bound = terms_[k].max_step(stage, path.q, path.d);
  return stage.near != nullptr && path.end < 1.0 ? std::min(bound, path.end) : bound;
}

double IncrementalPotential::max_step(Vec q, Vec d) {
  const Path path = terms_.arrays().along(q, d);
  double mine = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < terms_.size(); ++k) mine = std::min(mine, step_bound(k, path));
  return minimum(layout_.comm, mine);
}

bool IncrementalPotential::has_walls() const {
  return std::ranges::any_of(terms_.all(), [](const EnergyTerm* term) { return term->declaration().is_wall; });
}

double IncrementalPotential::max_step_to_wall(Vec q, Vec d, Walls which) {
  double mine = std::numeric_limits<double>::infinity();
  if (!has_walls()) return mine;
  const Path path = terms_.arrays().along(q, d);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    const TermDeclaration is = terms_[k].declaration();
    if (which == Walls::all ? is.is_wall : is.is_two_sided) mine = std::min(mine, step_bound(k, path));
  }
  return minimum(layout_.comm, mine);
}

bool IncrementalPotential::move_rigidly(Vec q) {
  const LocalStage& stage = terms_.arrays().stage();
  if (free_bodies_.empty() || stage.accepted.empty()) return false;
  // The state that inertia alone would reach.
  check(VecWAXPY(work_.get(), stage.dt, terms_.arrays().v0(), terms_.arrays().q0()));
  check(VecCopy(terms_.arrays().accepted(), q));
  for (const auto& nodes : free_bodies_) {
    const Placement from = nearest_placement(layout_, nodes, {}, terms_.arrays().accepted());
    const Placement to = nearest_placement(layout_, nodes, {}, work_.get());
    const ArrayView u(q);
    for (const PetscInt a : nodes) {
      const Vector3<double> X = layout_.position(a);
      const Vector3<double> now = {X[0] + u[3 * a], X[1] + u[3 * a + 1], X[2] + u[3 * a + 2]};
      // x = x_to(x_from^-1(now)): small differences survive, because the two rotations are nearly equal.
      const Vector3<double> moved = moved_from(from, to, now);
      for (std::size_t i = 0; i < 3; ++i) u[3 * a + static_cast<PetscInt>(i)] += moved[i];
    }
  }
  return true;
}

bool IncrementalPotential::follow_obstacles(Followers which, Vec q) {
  if (terms_.arrays().stage().accepted.empty()) return false;
  terms_.arrays().return_to_accepted();
  std::vector<Vector3<double>> displacements(static_cast<std::size_t>(layout_.num_local_nodes));
  std::vector<double> closeness(displacements.size(), 0.0);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    terms_[k].follow_obstacle(terms_.stage_of(k), displacements, closeness);
  }
  if (which == Followers::bodies) {
    // The mean displacement of the nearest nodes, over all ranks.
    std::vector<double> sums(4, 0.0);
    for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
      if (closeness[a] < 1.0) continue;
      for (std::size_t i = 0; i < 3; ++i) sums[i] += displacements[a][i];
      sums[3] += 1.0;
    }
    sum_in_place(layout_.comm, sums);
    if (sums[3] == 0.0) return false;
    std::ranges::fill(displacements, (1.0 / sums[3]) * Vector3<double>{sums[0], sums[1], sums[2]});
    std::ranges::fill(closeness, 1.0);
  } else if (!any_rank(layout_.comm, std::ranges::any_of(closeness, [](double near) { return near > 0.0; }))) {
    return false;
  }
  check(VecCopy(terms_.arrays().accepted(), q));
  const ArrayView u(q);
  for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
    for (PetscInt i = 0; i < 3; ++i) u[3 * a + i] += closeness[a] * displacements[a][static_cast<std::size_t>(i)];
  }
  return true;
}

bool IncrementalPotential::follow_prescribed_nodes(Vec q) {
  if (terms_.arrays().stage().accepted.empty()) return false;
  const ArrayView u(q);
  const ConstArrayView accepted(terms_.arrays().accepted());
  std::vector<double> sums(4, 0.0);
  for (PetscInt a = 0; a < layout_.num_owned_nodes; ++a) {
    Vector3<double> moved{};
    for (PetscInt i = 0; i < 3; ++i) {
      if (prescribed_[3 * a + i]) moved[static_cast<std::size_t>(i)] = u[3 * a + i] - accepted[3 * a + i];
    }
    if (moved == Vector3<double>{}) continue;
    for (std::size_t i = 0; i < 3; ++i) sums[i] += moved[i];
    sums[3] += 1.0;
  }
  sum_in_place(layout_.comm, sums);
  if (sums[3] == 0.0) return false;
  for (PetscInt e = 0; e < 3 * layout_.num_owned_nodes; ++e) {
    u[e] = accepted[e] + sums[static_cast<std::size_t>(e % 3)] / sums[3];
  }
  return true;
}

double IncrementalPotential::rounding_floor(Vec q) const {
  double squares = 0.0;
  const ConstArrayView u(q), k(diagonal_.get());
  for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
    if (!prescribed_[i]) squares += std::pow(k[i] * u[i], 2);
  }
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum(layout_.comm, squares)) + sum_rounding_;
}

double IncrementalPotential::rounding_energy(Vec q) const {
  double sum_of_squares = 0.0;
  const ConstArrayView u(q), k(diagonal_.get());
  for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
    const double place = std::abs(u[i]) + std::abs(layout_.coordinates[static_cast<std::size_t>(i)]);
    if (!prescribed_[i]) sum_of_squares += std::abs(k[i]) * std::pow(std::numeric_limits<double>::epsilon() * place, 2);
  }
  return 0.5 * sum(layout_.comm, sum_of_squares);
}

std::vector<std::string> IncrementalPotential::non_potentials() const {
  std::vector<std::string> names;
  for (const EnergyTerm* term : terms_.all()) {
    if (term->declaration().is_potential || std::ranges::find(names, term->name()) != names.end()) continue;
    names.emplace_back(term->name());
  }
  return names;
}

Symmetry IncrementalPotential::symmetry() const {
  for (const Symmetry symmetry : {Symmetry::unsymmetric, Symmetry::nearly_symmetric}) {
    const auto is_such = [&](const EnergyTerm* term) { return term->declaration().symmetry == symmetry; };
    if (std::ranges::any_of(terms_.all(), is_such)) return symmetry;
  }
  return Symmetry::symmetric;
}

Handle<Vec> IncrementalPotential::make_internal() const {
  Handle<Vec> z;
  const auto size = static_cast<PetscInt>(terms_.num_internal());
  if (sum(layout_.comm, static_cast<PetscInt64>(size)) == 0) return z;
  check(VecCreateMPI(layout_.comm, size, PETSC_DECIDE, z.out()));
  return z;
}

InternalVariables IncrementalPotential::internal_variables() {
  InternalVariables internal;
  internal.end_stage = [this](const StagePoint& stage, Vec q, Vec z) {
    begin_stage(stage);
    const auto at = terms_.arrays().at(q);
    const ArrayView values(z);
    for (std::size_t k = 0; k < terms_.size(); ++k)
      terms_[k].end_stage(terms_.stage_of(k), at, terms_.internal_of(k, values.span()));
  };
  internal.complete_step = [this](Vec accepted_z, Vec q, Vec z) {
    const auto at = terms_.arrays().at(q);
    const ArrayView values(z);
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      terms_[k].complete_step(terms_.internal_of(k, accepted_z), at, terms_.internal_of(k, values.span()));
    }
  };
  return internal;
}

}  // namespace pliant
