#include "study/vibration.hpp"

#include "energy/constraint/beside_identity.hpp"
#include "material/viscosity_registry.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/session.hpp"
#include "solver/merit.hpp"
#include "time/method.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

/// Whether its stress follows from the present rate of strain alone.
bool has_no_memory(const ViscosityLaw& law) {
  return std::holds_alternative<KelvinVoigt>(law) || std::holds_alternative<StiffnessProportional>(law) ||
         std::holds_alternative<MassProportional>(law);
}

/// The input with what damps by the present rate alone, in the form of a rate that has a potential.
Config with_rates_alone(Config config, std::vector<std::string>& relaxing) {
  config.time.method.kind = *find_method("backward-euler");
  for (BodyConfig& body : config.bodies) {
    for (const ViscosityConfig& mechanism : body.viscosity) {
      const std::string name(name_of(mechanism.law));
      if (!has_no_memory(mechanism.law) && std::ranges::find(relaxing, name) == relaxing.end())
        relaxing.push_back(name);
    }
    std::erase_if(body.viscosity, [](const ViscosityConfig& mechanism) { return !has_no_memory(mechanism.law); });
    for (ViscosityConfig& mechanism : body.viscosity) mechanism.rate = StrainRate::secant;
  }
  return config;
}

void require_potential(const Config& config, Model& model, double load_factor) {
  std::vector<std::string_view> names;
  for (const EnergyTerm* term : model.potential().terms()) {
    // Pressures as unknowns make a saddle point, whose matrix is symmetric.
    if (term->declaration().is_potential || dynamic_cast<const MixedTerm*>(term) != nullptr) continue;
    if (std::ranges::find(names, term->name()) == names.end()) names.push_back(term->name());
  }
  if (names.empty() && is_symmetric(model.equation().symmetry())) return;
  throw InputError(
      {config.file, 0, 0},
      fmt::format("forces without a potential have no real modes: {}; remove them{}", fmt::join(names, ", "),
                  load_factor > 0.0 ? ", or find the modes without loads (--unloaded)" : ""));
}

}  // namespace

void require_mass(const Config& config, const Model& model) {
  if (model.inertia() != nullptr && sum(model.layout().comm, model.inertia()->mass().total()) > 0.0) return;
  const Location where = config.bodies.empty() ? Location{config.file, 0, 0} : config.bodies.front().where;
  throw InputError(where, "modes need a mass: give the bodies a 'density'");
}

Vibration::Vibration(const Config& config, Model& model, const BaseState& about) : model_(model) {
  q_ = make_vector(model.layout());
  zero_ = make_vector(model.layout());
  check(VecCopy(about.q, q_.get()));
  update_ghosts(q_.get());
  measure_mass(q_.get());
  require_potential(config, model, about.load_factor);
  find_free(model.equation());
  set_matrices(about);
  if (!has_motion_) {
    throw InputError({config.file, 0, 0}, "constraints hold everything that has a mass: there is nothing to vibrate");
  }
  set_damping(config, about);
}

StagePoint Vibration::stage(const BaseState& about) const {
  return {.time = about.time,
          .dt = 1.0,
          .q0 = q_.get(),
          .v0 = zero_.get(),
          .load_factor = about.load_factor,
          .step_start = about.time - 1.0,
          .z0 = about.z,
          .accepted = q_.get(),
          .accepted_z = about.z};
}

void Vibration::measure_mass(Vec q) {
  const NodeLayout& layout = model_.layout();
  const Inertia& inertia = *model_.inertia();
  const ConstGhostedView u(q);
  std::vector<double> x(layout.coordinates.begin(), layout.coordinates.end()), velocity(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += u.span()[i];
  const std::vector<double> zero(x.size(), 0.0);
  std::vector<double> sums{inertia.mass().total()};
  const Momenta first = inertia.momenta(zero, x, x);  // of the velocity x: the first moment of mass
  sums.insert(sums.end(), first.linear.begin(), first.linear.end());
  sum_in_place(layout.comm, sums);
  mass_ = sums[0];
  for (std::size_t i = 0; i < 3; ++i) centre_[i] = sums[1 + i] / mass_;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= centre_[i % 3];
  std::vector<double> moments;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    for (std::size_t a = 0; a < x.size(); a += 3) {
      velocity[a + i] = 0.0;
      velocity[a + j] = -x[a + k];
      velocity[a + k] = x[a + j];
    }
    moments.push_back(inertia.momenta(zero, x, velocity).angular[i]);
  }
  sum_in_place(layout.comm, moments);
  std::ranges::copy(moments, moments_.begin());
}

void Vibration::find_free(const StageEquation& equation) {
  const Handle<Vec> like = equation.make_vector();
  PetscInt first = 0, last = 0;
  check(VecGetOwnershipRange(like.get(), &first, &last));
  std::vector<PetscInt> numbers;
  for (PetscInt i = 0; i < last - first; ++i) {
    if (equation.prescribed()[static_cast<std::size_t>(i)] != 0) continue;
    free_.push_back(i);
    numbers.push_back(first + i);
  }
  check(ISCreateGeneral(equation.comm(), static_cast<PetscInt>(numbers.size()), numbers.data(), PETSC_COPY_VALUES,
                        free_set_.out()));
  const PetscInt num_displacements = 3 * model_.layout().num_owned_nodes;
  const auto of_constraints = std::ranges::count_if(free_, [&](PetscInt i) { return i >= num_displacements; });
  num_negative_ = static_cast<PetscInt>(sum(equation.comm(), static_cast<PetscInt64>(of_constraints))) +
                  static_cast<PetscInt>(equation.num_rank_one());
}

Handle<Mat> Vibration::part_of_free(Mat whole) const {
  Handle<Mat> part;
  check(MatCreateSubMatrix(whole, free_set_.get(), free_set_.get(), MAT_INITIAL_MATRIX, part.out()));
  check(MatSetOption(part.get(), MAT_SYMMETRIC, PETSC_TRUE));
  return part;
}

void Vibration::set_matrices(const BaseState& about) {
  StageEquation& equation = model_.equation();
  const Handle<Vec> xi = equation.make_vector(), r = equation.make_vector();
  y_ = make_vector(model_.layout());
  check(VecCopy(q_.get(), y_.get()));
  equation.enter(stage(about), y_.get(), xi.get());
  equation.extrapolate_from(nullptr);
  equation.freeze(xi.get());
  equation.gradient(xi.get(), r.get());
  const double forces = equation.force_scale(xi.get()), unbalanced = norm(r.get());
  imbalance_ = unbalanced > equation.rounding_floor(xi.get()) ? unbalanced / std::max(forces, unbalanced) : 0.0;
  const Handle<Mat> K = equation.make_hessian();
  equation.hessian(xi.get(), K.get(), Projection::none);
  std::vector<RankOne> parts(equation.num_rank_one());
  for (RankOne& part : parts) part.g = equation.make_vector();
  equation.rank_one_parts(xi.get(), parts);
  K_ = part_of_free(K.get());
  const Handle<Mat> M = reduced_mass(about);
  const BesideIdentity whole(M.get(), xi.get());
  {
    // Pressures have no mass.
    check(MatGetDiagonal(whole.matrix(), r.get()));
    const ArrayView diagonal(r.get());
    std::fill(diagonal.span().begin() + 3 * model_.layout().num_owned_nodes, diagonal.span().end(), 0.0);
  }
  check(MatDiagonalSet(whole.matrix(), r.get(), INSERT_VALUES));
  M_ = part_of_free(whole.matrix());
  PetscReal largest = 0.0;
  check(MatNorm(M_.get(), NORM_INFINITY, &largest));
  has_motion_ = largest > 0.0;
  if (!parts.empty()) add_rank_one(parts);
}

Handle<Mat> Vibration::reduced_mass(const BaseState& about) const {
  IncrementalPotential inertia(model_.layout(), model_.pattern(), {model_.inertia()},
                               model_.constraints().prescribed().flags());
  std::optional<ConstrainedEquation> constrained;
  if (ConstraintMap* const map = model_.constraints().map()) constrained.emplace(inertia, *map);
  StageEquation& equation = constrained ? static_cast<StageEquation&>(*constrained) : inertia;
  const Handle<Vec> y = equation.make_vector();
  equation.enter(stage(about), y_.get(), y.get());
  Handle<Mat> M = equation.make_hessian();
  // The curvature of a map multiplies forces, and bodies at rest have no forces of inertia.
  equation.hessian(y.get(), M.get(), Projection::positive_semidefinite);
  return M;
}

void Vibration::add_rank_one(const std::vector<RankOne>& parts) {
  const Handle<Vec> diagonal = make_free_vector();
  check(MatGetDiagonal(K_.get(), diagonal.get()));
  PetscInt number = 0;
  check(VecGetSize(diagonal.get(), &number));
  double total = 0.0;
  check(VecNorm(diagonal.get(), NORM_1, &total));
  const double scale = std::sqrt(total > 0.0 ? total / number : 1.0);
  std::vector<Handle<Vec>> columns;
  for (const RankOne& part : parts) {
    const Handle<Vec>& column = columns.emplace_back(make_free_vector());
    const ConstArrayView from(part.g.get());
    const ArrayView to(column.get());
    for (std::size_t i = 0; i < free_.size(); ++i) {
      to[static_cast<PetscInt>(i)] = scale * std::sqrt(part.c) * from[free_[i]];
    }
  }
  K_ = bordered(K_.get(), columns, scale);
  M_ = bordered(M_.get(), std::vector<Handle<Vec>>(parts.size()), 0.0);
}

Handle<Vec> Vibration::make_free_vector() const {
  Handle<Vec> x;
  check(MatCreateVecs(K_.get(), x.out(), nullptr));
  return x;
}

// [A, G; G^T, -s^2] with G = s (sqrt(c_1) g_1, ...): its Schur complement is A + sum c_i g_i g_i^T.
Handle<Mat> Vibration::bordered(Mat A, const std::vector<Handle<Vec>>& columns, double scale) const {
  MPI_Comm comm = model_.layout().comm;
  const auto num_new = static_cast<PetscInt>(columns.size());
  const bool is_last = rank(comm) == num_ranks(comm) - 1;
  PetscInt first = 0, last = 0, total = 0;
  check(MatGetOwnershipRange(A, &first, &last));
  check(MatGetSize(A, &total, nullptr));
  std::vector<PetscInt> rows, places;
  std::vector<double> values;
  const auto add = [&](PetscInt i, PetscInt j, double value) {
    rows.push_back(i);
    places.push_back(j);
    values.push_back(value);
  };
  for (PetscInt row = first; row < last; ++row) {
    PetscInt count = 0;
    const PetscInt* of_row = nullptr;
    const double* entries = nullptr;
    check(MatGetRow(A, row, &count, &of_row, &entries));
    for (PetscInt k = 0; k < count; ++k) add(row, of_row[k], entries[k]);
    check(MatRestoreRow(A, row, &count, &of_row, &entries));
  }
  for (PetscInt k = 0; k < num_new; ++k) {
    if (is_last) add(total + k, total + k, -scale * scale);
    if (!columns[static_cast<std::size_t>(k)]) continue;
    const ConstArrayView g(columns[static_cast<std::size_t>(k)].get());
    for (PetscInt row = first; row < last; ++row) {
      if (g[row - first] == 0.0) continue;
      add(row, total + k, g[row - first]);
      add(total + k, row, g[row - first]);
    }
  }
  const PetscInt size = last - first + (is_last ? num_new : 0);
  Handle<Mat> whole;
  check(MatCreate(comm, whole.out()));
  check(MatSetSizes(whole.get(), size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(whole.get(), MATMPIAIJ));
  check(MatSetPreallocationCOO(whole.get(), static_cast<PetscCount>(rows.size()), rows.data(), places.data()));
  check(MatSetValuesCOO(whole.get(), values.data(), INSERT_VALUES));
  check(MatSetOption(whole.get(), MAT_SYMMETRIC, PETSC_TRUE));
  return whole;
}

void Vibration::set_damping(const Config& config, const BaseState& about) {
  damping_terms_ = model_.viscous_terms(with_rates_alone(config, relaxing_));
  std::vector<const EnergyTerm*> terms;
  for (const auto& term : damping_terms_) terms.push_back(term.get());
  for (const auto& of_rods : model_.rods().viscosity) terms.push_back(of_rods.get());
  for (const ModelShell& shell : model_.shells().shells) {
    if (shell.membrane.viscosity) terms.push_back(shell.membrane.viscosity.get());
    if (shell.bending_viscosity) terms.push_back(shell.bending_viscosity.get());
  }
  if (terms.empty()) return;
  damping_ = std::make_unique<IncrementalPotential>(model_.layout(), model_.pattern(), std::move(terms),
                                                    model_.constraints().prescribed().flags());
  BaseState without_internal = about;
  without_internal.z = nullptr;
  damping_->begin_stage(stage(without_internal));
  C_ = damping_->make_hessian();
  damping_->hessian(q_.get(), C_.get(), Projection::none);
}

double Vibration::dissipation(Vec u) const {
  if (damping_ == nullptr) return 0.0;
  const Handle<Vec> f = make_vector(model_.layout());
  check(MatMult(C_.get(), u, f.get()));
  // Prescribed entries do not move; their rows hold a diagonal alone.
  return dot(u, f.get());
}

void Vibration::expand(Vec x, Vec u) const {
  check(VecZeroEntries(y_.get()));
  {
    const ConstArrayView from(x);
    const ArrayView to(y_.get());
    const PetscInt num_displacements = 3 * model_.layout().num_owned_nodes;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (free_[i] < num_displacements) to[free_[i]] = from[static_cast<PetscInt>(i)];
    }
  }
  if (const ConstraintMap* map = model_.constraints().map()) {
    check(MatMult(map->jacobian(), y_.get(), u));
  } else {
    check(VecCopy(y_.get(), u));
  }
  update_ghosts(u);
}

std::array<double, num_momenta> Vibration::momenta(Vec u) const {
  const NodeLayout& layout = model_.layout();
  const ConstGhostedView velocity(u), q(q_.get());
  const Momenta mine = model_.inertia()->momenta(layout.coordinates, q.span(), velocity.span());
  std::vector<double> sums(mine.linear.begin(), mine.linear.end());
  sums.insert(sums.end(), mine.angular.begin(), mine.angular.end());
  sum_in_place(layout.comm, sums);
  std::array<double, num_momenta> result{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double about_centre = sums[3 + i] - (centre_[j] * sums[k] - centre_[k] * sums[j]);
    result[i] = sums[i] / std::sqrt(mass_);
    result[3 + i] = moments_[i] > 0.0 ? about_centre / std::sqrt(moments_[i]) : 0.0;
  }
  return result;
}

}  // namespace pliant
