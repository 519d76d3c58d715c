#include "energy/equation/mixed_equation.hpp"

#include "energy/equation/saddle_point.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/matrix_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// The first number of each rank, and the total.
std::vector<PetscInt> starts(MPI_Comm comm, PetscInt mine) {
  int size = 1;
  check_mpi(MPI_Comm_size(comm, &size));
  std::vector<PetscInt> result(static_cast<std::size_t>(size) + 1, 0);
  check_mpi(MPI_Allgather(&mine, 1, MPIU_INT, result.data() + 1, 1, MPIU_INT, comm));
  for (std::size_t r = 1; r < result.size(); ++r) result[r] += result[r - 1];
  return result;
}

std::size_t owner_of(const std::vector<PetscInt>& starts, PetscInt global) {
  return static_cast<std::size_t>(std::upper_bound(starts.begin(), starts.end(), global) - starts.begin()) - 1;
}

}  // namespace

MixedEquation::MixedEquation(IncrementalPotential& potential, const NodeLayout& layout,
                             std::vector<const MixedTerm*> mixed, PressureField& pressures,
                             std::span<const int> rigid_parts)
    : potential_(potential),
      layout_(layout),
      mixed_(std::move(mixed)),
      pressures_(pressures),
      num_q_(3 * layout.num_owned_nodes),
      num_p_(pressures.layout().num_owned),
      first_node_(starts(layout.comm, layout.num_owned_nodes)),
      first_pressure_(starts(layout.comm, num_p_)),
      prescribed_(potential.prescribed().begin(), potential.prescribed().begin() + num_q_),
      K_(potential.make_hessian()) {
  pattern_of_K_ = pattern_id(K_.get());
  prescribed_.resize(static_cast<std::size_t>(num_q_ + num_p_), 0);
  for (Handle<Vec>* v : {&q_, &r_, &d_}) *v = pliant::make_vector(layout);
  for (Handle<Vec>* v : {&q0_, &v0_, &accepted_}) *v = make_vector();
  for (Handle<Vec>* v : {&work_, &last_pressures_}) *v = pliant::make_vector(pressures.layout(), layout.comm);

  for (std::size_t k = 0; k < potential.num_rank_one(); ++k) rank_one_.push_back({0.0, potential.make_vector()});

  double stiffness = 0.0;
  for (const MixedTerm* term : mixed_) stiffness = std::max(stiffness, term->shear_modulus());
  stiffness = maximum(layout.comm, stiffness);
  {
    const GhostedView volumes(work_.get());
    for (const MixedTerm* term : mixed_) term->add_pressure_volumes(volumes.span());
    double volume = 0.0;
    for (PetscInt i = 0; i < num_p_; ++i) volume += volumes.span()[i];
    volume = sum(layout_.comm, volume);
    scale_ = stiffness / std::cbrt(volume / static_cast<double>(layout_.num_global_cells));
    for (PetscInt i = 0; i < num_p_; ++i) {
      pressure_diagonal_.push_back(scale_ * scale_ * volumes.span()[i] / stiffness);
    }
  }
  find_idle_pressures(rigid_parts);
}

void MixedEquation::find_idle_pressures(std::span<const int> rigid_parts) {
  const auto is_given = [&](PetscInt node) {
    return is_prescribed(node, 0) && is_prescribed(node, 1) && is_prescribed(node, 2);
  };
  const auto moves_as_given = [&](const PressureCoupling& cells, int lane) {
    const auto part_of = [&](PetscInt node) {
      return rigid_parts.empty() ? 0 : rigid_parts[static_cast<std::size_t>(node)];
    };
    const int part = part_of(cells.nodes[0][lane]);
    bool all_given = true, all_rigid = part != 0;
    for (const auto& node : cells.nodes) {
      all_given = all_given && is_given(node[lane]);
      all_rigid = all_rigid && part_of(node[lane]) == part;
    }
    return all_given || all_rigid;
  };
  {
    const GhostedView is_needed(work_.get());
    std::fill(is_needed.span().begin(), is_needed.span().end(), 0.0);
    const std::vector<double> rest(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0.0);
    for (const MixedTerm* term : mixed_) {
      // Stabilized pressures depend on those of neighbouring cells: none is idle if one is not.
      bool any_needed = false, are_stabilized = false;
      term->couple({}, rest, [&](const PressureCoupling& cells) {
        for (int lane = 0; lane < cells.num_lanes; ++lane) {
          const bool needs_all = cells.is_compressible[lane] || !moves_as_given(cells, lane);
          any_needed = any_needed || needs_all;
          are_stabilized = are_stabilized || (!cells.is_compressible[lane] && cells.C[0][1][lane] != 0.0);
          for (int b = 0; b < 4 && needs_all; ++b) is_needed.span()[cells.pressures[b][lane]] = 1.0;
        }
      });
      any_needed = maximum(layout_.comm, any_needed ? 1.0 : 0.0) > 0.0;
      if (!any_needed || !are_stabilized) continue;
      term->couple({}, rest, [&](const PressureCoupling& cells) {
        for (const auto& numbers : cells.pressures) {
          for (int lane = 0; lane < cells.num_lanes; ++lane) is_needed.span()[numbers[lane]] = 1.0;
        }
      });
    }
  }
  update_ghosts(work_.get());
  const ConstGhostedView is_needed(work_.get());
  for (const double needed : is_needed.span()) is_idle_.push_back(needed == 0.0 ? 1 : 0);
  std::copy_n(is_idle_.begin(), num_p_, prescribed_.begin() + num_q_);
}

bool MixedEquation::determines_pressures() const {
  return are_felt(mixed_, layout_, prescribed_, is_idle_);
}

PetscInt MixedEquation::global_displacement(PetscInt entry) const {
  return entry + first_pressure_[owner_of(first_node_, entry / 3)];
}

PetscInt MixedEquation::global_pressure(PetscInt pressure) const {
  const PressureLayout& p = pressures_.layout();
  const PetscInt global = pressure < p.num_owned ? p.first_global + pressure : p.ghost_globals[pressure - p.num_owned];
  return global + 3 * first_node_[owner_of(first_pressure_, global) + 1];
}

Handle<Vec> MixedEquation::make_vector() const {
  Handle<Vec> x;
  check(VecCreateMPI(layout_.comm, num_q_ + num_p_, PETSC_DECIDE, x.out()));
  return x;
}

void MixedEquation::take_displacement(Vec x, Vec q) const {
  const ConstArrayView from(x);
  const ArrayView to(q);
  std::copy_n(from.span().begin(), num_q_, to.span().begin());
}

Vec MixedEquation::displacements(Vec x) {
  take_displacement(x, q_.get());
  return q_.get();
}

void MixedEquation::set(Vec x) {
  take_displacement(x, q_.get());
  {
    const ConstArrayView from(x);
    const ArrayView p(pressures_.values());
    for (PetscInt i = 0; i < num_p_; ++i) p[i] = scale_ * from[num_q_ + i];
  }
  update_ghosts(pressures_.values());
}

void MixedEquation::join(Vec q, Vec x) const {
  const ConstArrayView from(q), p(pressures_.values());
  const ArrayView to(x);
  std::copy_n(from.span().begin(), num_q_, to.span().begin());
  for (PetscInt i = 0; i < num_p_; ++i) to[num_q_ + i] = p[i] / scale_;
}

StagePoint MixedEquation::enter(const StagePoint& stage, Vec q, Vec x) {
  potential_.begin_stage(stage);
  instant_ = {stage.time, stage.load_factor};
  check(VecCopy(pressures_.values(), last_pressures_.get()));
  join(q, x);
  join(stage.q0, q0_.get());
  join(stage.v0, v0_.get());
  {
    const ArrayView rate(v0_.get());
    std::fill(rate.span().begin() + num_q_, rate.span().end(), 0.0);
  }
  StagePoint whole = stage;
  whole.q0 = q0_.get();
  whole.v0 = v0_.get();
  if (stage.accepted != nullptr) {
    join(stage.accepted, accepted_.get());
    whole.accepted = accepted_.get();
  }
  return whole;
}

void MixedEquation::leave(Vec x, Vec q) {
  set(x);
  take_displacement(x, q);
}

void MixedEquation::give_up() {
  check(VecCopy(last_pressures_.get(), pressures_.values()));
  update_ghosts(pressures_.values());
}

void MixedEquation::keep(Archive& archive) {
  archive.vector("pressures", Entries::pressures, pressures_.values());
  update_ghosts(pressures_.values());
}

void MixedEquation::pressure_gradient(const Instant& at, std::span<const double> q, Vec r) const {
  const GhostedView rows(r);
  std::fill(rows.span().begin(), rows.span().end(), 0.0);
  for (const MixedTerm* term : mixed_) term->add_pressure_gradient(at, q, rows.span());
}

void MixedEquation::settle(Vec q, const Instant& at) {
  const bool changes = std::ranges::any_of(mixed_, [](const MixedTerm* m) { return m->declaration().depends_on_time; });
  if (!projection_ || changes) projection_.emplace(make_compliance(mixed_, layout_, pressures_.layout(), at));
  update_ghosts(q);
  const ConstGhostedView displacement(q);
  check(VecSet(pressures_.values(), 0.0));
  update_ghosts(pressures_.values());
  pressure_gradient(at, displacement.span(), work_.get());
  projection_->solve(work_.get(), pressures_.values());
  update_ghosts(pressures_.values());
}

void MixedEquation::freeze(Vec x) {
  take_displacement(x, q_.get());
  potential_.freeze(q_.get());
}

bool MixedEquation::refreeze(Vec x) {
  take_displacement(x, q_.get());
  return potential_.refreeze(q_.get());
}

void MixedEquation::drag(Vec x, Vec at, Vec f) {
  take_displacement(x, q_.get());
  take_displacement(at, d_.get());
  potential_.drag(q_.get(), d_.get(), r_.get());
  check(VecZeroEntries(f));
  const ConstArrayView from(r_.get());
  const ArrayView to(f);
  std::copy_n(from.span().begin(), num_q_, to.span().begin());
}

double MixedEquation::value(Vec x) {
  set(x);
  return potential_.value(q_.get());
}

void MixedEquation::gradient(Vec x, Vec r) {
  set(x);
  potential_.gradient(q_.get(), r_.get());
  update_ghosts(q_.get());
  {
    const ConstGhostedView q(q_.get());
    pressure_gradient(instant_, q.span(), work_.get());
  }
  const ConstArrayView from(r_.get()), rows(work_.get());
  const ArrayView to(r);
  std::copy_n(from.span().begin(), num_q_, to.span().begin());
  for (PetscInt i = 0; i < num_p_; ++i) {
    to[num_q_ + i] = is_idle_[static_cast<std::size_t>(i)] ? 0.0 : scale_ * rows[i];
  }
}

template <class Visit>
void MixedEquation::for_each_coupling(std::span<const double> q, const Visit& visit) const {
  for (const MixedTerm* term : mixed_) {
    term->couple(instant_, q, [&](const PressureCoupling& cells) {
      for (int lane = 0; lane < cells.num_lanes; ++lane) {
        for (int b = 0; b < 4; ++b) {
          const PetscInt p = cells.pressures[b][lane];
          const PetscInt global_p = global_pressure(p);
          for (std::size_t a = 0; a < cells.nodes.size(); ++a) {
            const PetscInt node = cells.nodes[a][lane];
            for (int i = 0; i < 3; ++i) {
              const PetscInt global_q = global_displacement(3 * layout_.global_node(node) + i);
              const bool is_fixed = is_idle_[static_cast<std::size_t>(p)] || is_prescribed(node, i);
              const double entry = is_fixed ? 0.0 : scale_ * cells.B[3 * a + static_cast<std::size_t>(i)][b][lane];
              if (node < layout_.num_owned_nodes) visit(global_q, global_p, entry);
              if (p < num_p_) visit(global_p, global_q, entry);
            }
          }
          for (int c = 0; c < 4 && p < num_p_; ++c) {
            const bool is_idle = b == c && is_idle_[static_cast<std::size_t>(p)];
            visit(global_p, global_pressure(cells.pressures[c][lane]),
                  is_idle ? -pressure_diagonal_[static_cast<std::size_t>(p)] : -scale_ * scale_ * cells.C[b][c][lane]);
          }
        }
      }
    });
  }
}

Handle<Mat> MixedEquation::make_hessian() const {
  // The entries of K in the order of its two parts, then those that couple the pressures.
  std::vector<PetscInt> rows, columns;
  Mat parts[2] = {nullptr, nullptr};
  const PetscInt* others = nullptr;  // columns of the second part, over all ranks
  check(MatMPIAIJGetSeqAIJ(K_.get(), &parts[0], &parts[1], &others));
  for (int part = 0; part < 2; ++part) {
    PetscInt num_rows = 0;
    const PetscInt *offsets = nullptr, *places = nullptr;
    PetscBool is_done = PETSC_FALSE;
    check(MatGetRowIJ(parts[part], 0, PETSC_FALSE, PETSC_FALSE, &num_rows, &offsets, &places, &is_done));
    for (PetscInt row = 0; row < num_rows; ++row) {
      for (PetscInt k = offsets[row]; k < offsets[row + 1]; ++k) {
        const PetscInt column = part == 0 ? 3 * layout_.first_global_node + places[k] : others[places[k]];
        rows.push_back(global_displacement(3 * layout_.first_global_node + row));
        columns.push_back(global_displacement(column));
      }
    }
    check(MatRestoreRowIJ(parts[part], 0, PETSC_FALSE, PETSC_FALSE, &num_rows, &offsets, &places, &is_done));
  }
  const std::vector<double> rest(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0.0);
  for_each_coupling(rest, [&](PetscInt row, PetscInt column, double) {
    rows.push_back(row);
    columns.push_back(column);
  });
  const std::size_t num_entries = rows.size();
  Handle<Mat> A;
  check(MatCreate(layout_.comm, A.out()));
  check(MatSetSizes(A.get(), num_q_ + num_p_, num_q_ + num_p_, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(A.get(), MATMPIAIJ));
  check(MatSetPreallocationCOO(A.get(), static_cast<PetscCount>(num_entries), rows.data(), columns.data()));
  const std::vector<double> zeros(num_entries, 0.0);
  check(MatSetValuesCOO(A.get(), zeros.data(), INSERT_VALUES));
  const PetscBool is_symmetric = pliant::is_symmetric(symmetry()) ? PETSC_TRUE : PETSC_FALSE;
  check(MatSetOption(A.get(), MAT_SYMMETRIC, is_symmetric));
  check(MatSetOption(A.get(), MAT_SYMMETRY_ETERNAL, is_symmetric));
  attach_parts(A.get());
  return A;
}

// -Schur complement = s^2 (C + B^T K^-1 B), where B^T K^-1 B is close to the mass matrix of the pressures over the
// shear modulus (Elman, Silvester & Wathen, Finite Elements and Fast Iterative Solvers, 2nd ed. 2014, chapter 3).
void MixedEquation::attach_parts(Mat A) const {
  PetscInt first = 0;
  check(MatGetOwnershipRange(A, &first, nullptr));
  Handle<IS> displacements, pressures;
  check(ISCreateStride(layout_.comm, num_q_, first, 1, displacements.out()));
  check(ISCreateStride(layout_.comm, num_p_, first + num_q_, 1, pressures.out()));
  check(ISSetBlockSize(displacements.get(), 3));
  MatNullSpace near_null = nullptr;
  check(MatGetNearNullSpace(K_.get(), &near_null));
  if (near_null != nullptr) {
    check(PetscObjectCompose(reinterpret_cast<PetscObject>(displacements.get()), "nearnullspace",
                             reinterpret_cast<PetscObject>(near_null)));
  }
  const Handle<Mat> schur = make_compliance(mixed_, layout_, pressures_.layout());
  check(MatScale(schur.get(), -scale_ * scale_));
  Handle<Vec> diagonal;
  check(MatCreateVecs(schur.get(), diagonal.out(), nullptr));
  {
    const ArrayView of_mass(diagonal.get());
    for (PetscInt i = 0; i < num_p_; ++i) of_mass[i] = -pressure_diagonal_[static_cast<std::size_t>(i)];
  }
  check(MatDiagonalSet(schur.get(), diagonal.get(), ADD_VALUES));
  attach(A, {displacements.get(), pressures.get(), schur.get()});
}

void MixedEquation::hessian(Vec x, Mat A, Projection projection) {
  set(x);
  potential_.hessian(q_.get(), K_.get(), projection);
  update_ghosts(q_.get());
  values_.clear();
  if (pattern_id(K_.get()) != pattern_of_K_) {
    pattern_of_K_ = pattern_id(K_.get());
    present_pattern_.change();
  }
  if (!present_pattern_.is_that_of(A)) present_pattern_.give(A, make_hessian());
  Mat parts[2] = {nullptr, nullptr};
  check(MatMPIAIJGetSeqAIJ(K_.get(), &parts[0], &parts[1], nullptr));
  for (Mat part : parts) {
    MatInfo info{};
    check(MatGetInfo(part, MAT_LOCAL, &info));
    const PetscScalar* entries = nullptr;
    check(MatSeqAIJGetArrayRead(part, &entries));
    values_.insert(values_.end(), entries, entries + static_cast<std::ptrdiff_t>(info.nz_used));
    check(MatSeqAIJRestoreArrayRead(part, &entries));
  }
  const ConstGhostedView q(q_.get());
  for_each_coupling(q.span(), [&](PetscInt, PetscInt, double value) { values_.push_back(value); });
  check(MatSetValuesCOO(A, values_.data(), INSERT_VALUES));
}

void MixedEquation::rank_one_parts(Vec x, std::vector<RankOne>& parts) {
  take_displacement(x, q_.get());
  potential_.rank_one_parts(q_.get(), rank_one_);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    parts[k].c = rank_one_[k].c;
    const ConstArrayView from(rank_one_[k].g.get());
    const ArrayView to(parts[k].g.get());
    std::copy_n(from.span().begin(), num_q_, to.span().begin());
  }
}

double MixedEquation::max_step(Vec x, Vec d) {
  take_displacement(x, q_.get());
  take_displacement(d, d_.get());
  return potential_.max_step(q_.get(), d_.get());
}

double MixedEquation::max_step_to_wall(Vec x, Vec d, Walls which) {
  take_displacement(x, q_.get());
  take_displacement(d, d_.get());
  return potential_.max_step_to_wall(q_.get(), d_.get(), which);
}

bool MixedEquation::move_rigidly(Vec x) {
  return join_if(potential_.move_rigidly(q_.get()), x);
}

bool MixedEquation::follow_obstacles(Followers which, Vec x) {
  return join_if(potential_.follow_obstacles(which, q_.get()), x);
}

bool MixedEquation::follow_prescribed_nodes(Vec x) {
  take_displacement(x, q_.get());
  return join_if(potential_.follow_prescribed_nodes(q_.get()), x);
}

double MixedEquation::force_scale(Vec x) {
  set(x);
  return potential_.force_scale(q_.get());
}

double MixedEquation::rounding_floor(Vec x) const {
  take_displacement(x, d_.get());
  const double of_q = potential_.rounding_floor(d_.get());
  const ConstArrayView values(x);
  double squares = 0.0;
  for (PetscInt i = 0; i < num_p_; ++i) {
    squares += std::pow(pressure_diagonal_[static_cast<std::size_t>(i)] * values[num_q_ + i], 2);
  }
  return std::hypot(of_q, std::numeric_limits<double>::epsilon() * std::sqrt(sum(layout_.comm, squares)));
}

void MixedEquation::size_of_diagonal(Mat A, Vec D) const {
  get_diagonal(A, D);
  const ArrayView diagonal(D);
  for (PetscInt i = 0; i < num_p_; ++i) {
    diagonal[num_q_ + i] = std::max(-diagonal[num_q_ + i], pressure_diagonal_[static_cast<std::size_t>(i)]);
  }
}

std::vector<std::string> MixedEquation::non_potentials() const {
  return potential_.non_potentials();
}

Symmetry MixedEquation::symmetry() const {
  return pliant::is_symmetric(potential_.symmetry()) ? Symmetry::indefinite : Symmetry::unsymmetric;
}

}  // namespace pliant
