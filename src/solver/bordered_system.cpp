#include "solver/bordered_system.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/matrix_pattern.hpp"
#include "petsc/near_null_space.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>

namespace pliant {
namespace {

/// Couplings below this part of the largest one are left out of Z.
constexpr double least_coupling = 1e-6;

/// The number of `row` in an ascending list; -1 if it is not there.
PetscInt number_in(const std::vector<PetscInt>& rows, PetscInt row) {
  const auto found = std::ranges::lower_bound(rows, row);
  return found != rows.end() && *found == row ? static_cast<PetscInt>(found - rows.begin()) : -1;
}

}  // namespace

BorderedSystem::BorderedSystem(KSP ksp, Mat K, std::vector<PetscInt> border, const std::vector<char>& prescribed,
                               const NodalRotations* rotations)
    : comm_(PetscObjectComm(reinterpret_cast<PetscObject>(K))),
      border_(std::move(border)),
      is_prescribed_(prescribed),
      rotations_(rotations) {
  check(MatGetOwnershipRange(K, &first_, &last_));
  check(MatCreateVecs(K, without_border_.out(), nullptr));
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectReference(reinterpret_cast<PetscObject>(pc)));
  inner_ = Handle<PC>(pc);
  Mat A = nullptr, preconditioned = nullptr;
  check(KSPGetOperators(ksp, &A, &preconditioned));
  Handle<PC> outer;
  check(PCCreate(comm_, outer.out()));
  check(PCSetType(outer.get(), PCSHELL));
  check(PCShellSetName(outer.get(), "rows of rigid bodies, by block elimination"));
  check(PCShellSetContext(outer.get(), this));
  check(PCShellSetApply(outer.get(), apply_callback));
  check(PCShellSetPreSolve(outer.get(), begin_callback));
  check(PCShellSetView(outer.get(), view_callback));
  check(KSPSetPC(ksp, outer.get()));
  check(KSPSetOperators(ksp, A, preconditioned));
}

void BorderedSystem::clear_border(Vec x) const {
  const ArrayView entries(x);
  for (const PetscInt row : border_) {
    if (owns(row)) entries[row - first_] = 0.0;
  }
}

void BorderedSystem::find_places(Mat K) {
  pattern_ = pattern_id(K);
  B_.clear();
  C_.clear();
  D_.clear();
  std::vector<PetscInt> columns_of_C;
  for (std::size_t part = 0; part < 2; ++part) {
    const MatrixRows rows(K, part);
    for (PetscInt row = 0; row < rows.size(); ++row) {
      const PetscInt of_border = number_in(border_, first_ + row);
      for (PetscInt k = rows.begin(row); k < rows.end(row); ++k) {
        const PetscInt column = number_in(border_, rows.column(k));
        if (of_border >= 0 && column >= 0) {
          D_.push_back({part, k, of_border, column});
        } else if (column >= 0) {
          B_.push_back({part, k, row, column});
        } else if (of_border >= 0) {
          C_.push_back({part, k, of_border, rows.column(k)});
          columns_of_C.push_back(rows.column(k));
        }
      }
    }
  }
  std::ranges::stable_sort(B_, {}, &Entry::row);
  std::ranges::sort(columns_of_C);
  columns_of_C.erase(std::unique(columns_of_C.begin(), columns_of_C.end()), columns_of_C.end());
  for (Entry& entry : C_) entry.column = number_in(columns_of_C, entry.column);
  const auto num_needed = static_cast<PetscInt>(columns_of_C.size());
  Handle<IS> wanted;
  check(ISCreateGeneral(PETSC_COMM_SELF, num_needed, columns_of_C.data(), PETSC_COPY_VALUES, wanted.out()));
  check(VecCreateSeq(PETSC_COMM_SELF, num_needed, needed_.out()));
  check(VecScatterCreate(without_border_.get(), wanted.get(), needed_.get(), nullptr, scatter_.out()));
  make_inner(K);
}

// Nodes whose entries all are of the border or prescribed keep the block of their diagonal alone: all nodes of the
// border, whose entries are unknowns of rigid bodies or follow from them.
void BorderedSystem::make_inner(Mat K) {
  constexpr std::size_t block = 3;
  std::vector<char> is_alone(static_cast<std::size_t>(last_ - first_), 0);
  const auto stands_apart = [&](std::size_t i) {
    return (i < is_prescribed_.size() && is_prescribed_[i] != 0) ||
           number_in(border_, first_ + static_cast<PetscInt>(i)) >= 0;
  };
  for (std::size_t node = 0; block * (node + 1) <= is_alone.size(); ++node) {
    const std::size_t i = block * node;
    if (stands_apart(i) && stands_apart(i + 1) && stands_apart(i + 2)) std::fill_n(is_alone.begin() + i, block, 1);
  }
  const auto column_is_alone = flags_of_columns(K, is_alone);
  const auto is_wanted = [&](const MatrixRows& rows, std::size_t part, PetscInt row, PetscInt k) {
    const auto column = static_cast<std::size_t>(rows.local_column(k));
    const auto i = static_cast<std::size_t>(row);
    if (!is_alone[i] && !column_is_alone[part][column]) return true;
    return part == 0 && is_alone[i] != 0 && i / block == column / block;
  };
  std::vector<PetscInt> offsets{0}, columns;
  {
    const MatrixRows own(K, 0), others(K, 1);
    for (PetscInt row = 0; row < own.size(); ++row) {
      const auto first = static_cast<std::ptrdiff_t>(columns.size());
      for (PetscInt k = own.begin(row); k < own.end(row); ++k) {
        if (is_wanted(own, 0, row, k)) columns.push_back(own.column(k));
      }
      for (PetscInt k = others.begin(row); k < others.end(row); ++k) {
        if (is_wanted(others, 1, row, k)) columns.push_back(others.column(k));
      }
      std::sort(columns.begin() + first, columns.end());
      offsets.push_back(static_cast<PetscInt>(columns.size()));
    }
  }
  A_ = make_zero_matrix(K, offsets, columns);
  for (const MatOption is : {MAT_SYMMETRIC, MAT_SYMMETRY_ETERNAL}) check(MatSetOption(A_.get(), is, PETSC_TRUE));
  for (std::size_t part = 0; part < 2; ++part) {
    const MatrixRows of_K(K, part), of_A(A_.get(), part);
    A_from_K_[part] = of_K.runs(of_A, [&](PetscInt row, PetscInt k) { return is_wanted(of_K, part, row, k); });
  }
}

Mat BorderedSystem::inner_matrix(Mat K) {
  if (pattern_id(K) != pattern_) find_places(K);
  {
    const MatrixValues from(K), to(A_.get());
    for (std::size_t part = 0; part < 2; ++part) {
      for (const EntryRun& run : A_from_K_[part]) std::copy_n(from[part] + run.from, run.count, to[part] + run.to);
    }
    // Blocks of the border's own nodes: the diagonal alone.
    const MatrixRows rows(A_.get(), 0);
    for (const PetscInt row : border_) {
      if (!owns(row)) continue;
      const PetscInt i = row - first_;
      for (PetscInt k = rows.begin(i); k < rows.end(i); ++k) {
        const PetscInt column = rows.local_column(k);
        double& value = to[0][k];
        value = column == i ? std::max(std::abs(value), 1.0) : 0.0;
        if (column == i) continue;
        for (PetscInt l = rows.begin(column); l < rows.end(column); ++l) {
          if (rows.local_column(l) == i) to[0][l] = 0.0;
        }
      }
    }
  }
  check(MatAssemblyBegin(A_.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(A_.get(), MAT_FINAL_ASSEMBLY));
  MatNullSpace space = nullptr;
  check(MatGetNearNullSpace(K, &space));
  if (space != nullptr) {
    PetscInt number = 0;
    const Vec* modes = nullptr;
    check(MatNullSpaceGetVecs(space, nullptr, &number, &modes));
    std::vector<Handle<Vec>> without;
    for (PetscInt m = 0; m < number; ++m) {
      Handle<Vec>& mode = without.emplace_back();
      check(VecDuplicate(modes[m], mode.out()));
      check(VecCopy(modes[m], mode.get()));
      clear_border(mode.get());
    }
    set_near_null_modes(A_.get(), std::move(without));
  }
  return A_.get();
}

void BorderedSystem::read(Mat K) {
  if (pattern_id(K) != pattern_) find_places(K);
  const MatrixValues values(K);
  for (std::vector<Entry>* block : {&B_, &C_, &D_}) {
    for (Entry& entry : *block) entry.value = values[entry.part][entry.place];
  }
}

void BorderedSystem::reduce(Matrix& sums) const {
  sum_in_place(comm_, std::span(sums.data(), static_cast<std::size_t>(sums.size())));
}

void BorderedSystem::set_up(Mat K) {
  read(K);
  // Independent columns of B, by the eigenvectors of B^T B.
  Matrix products = Matrix::Zero(size(), size());
  for (std::size_t begin = 0, end = 0; begin < B_.size(); begin = end) {
    while (end < B_.size() && B_[end].row == B_[begin].row) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      for (std::size_t j = begin; j < end; ++j) products(B_[i].column, B_[j].column) += B_[i].value * B_[j].value;
    }
  }
  reduce(products);
  directions_.clear();
  solutions_.clear();
  if (!(products.norm() > 0.0) || !products.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(products);
  const double largest = eigen.eigenvalues()[size() - 1];
  for (Eigen::Index j = size() - 1; j >= 0; --j) {
    const double value = eigen.eigenvalues()[j];
    if (!(value > least_coupling * least_coupling * largest)) break;
    Handle<Vec>& direction = directions_.emplace_back();
    check(VecDuplicate(without_border_.get(), direction.out()));
    check(VecZeroEntries(direction.get()));
    {
      const ArrayView entries(direction.get());
      for (const Entry& entry : B_) {
        entries[entry.row] += entry.value * eigen.eigenvectors()(entry.column, j) / std::sqrt(value);
      }
    }
    Handle<Vec>& solution = solutions_.emplace_back();
    check(VecDuplicate(without_border_.get(), solution.out()));
    check(PCApply(inner_.get(), direction.get(), solution.get()));
  }
}

void BorderedSystem::rotate(const std::vector<Handle<Vec>>& from, std::vector<Handle<Vec>>& to) const {
  to.resize(from.size());
  for (std::size_t j = 0; j < from.size(); ++j) {
    if (!to[j]) check(VecDuplicate(without_border_.get(), to[j].out()));
    check(VecCopy(from[j].get(), to[j].get()));
    if (rotations_ != nullptr) rotations_->turn(to[j].get());
  }
}

void BorderedSystem::follow(Mat K, std::span<const RankOne> parts) {
  read(K);
  rotate(directions_, rotated_directions_);
  rotate(solutions_, rotated_solutions_);
  const Eigen::Index n = size(), num_solutions = static_cast<Eigen::Index>(solutions_.size());
  const auto num_parts = static_cast<Eigen::Index>(parts.size());
  // D, then T, C Z and the entries of rank-one terms, in one sum over the ranks.
  Matrix sums = Matrix::Zero(n, n + 2 * num_solutions + num_parts);
  for (const Entry& entry : D_) sums(entry.row, entry.column) += entry.value;
  for (Eigen::Index j = 0; j < num_solutions; ++j) {
    const auto k = static_cast<std::size_t>(j);
    {
      const ConstArrayView direction(rotated_directions_[k].get());
      for (const Entry& entry : B_) sums(entry.column, n + j) += entry.value * direction[entry.row];
    }
    subtract_coupling(rotated_solutions_[k].get(), sums.col(n + num_solutions + j));
  }
  for (Eigen::Index j = 0; j < num_parts; ++j) {
    const RankOne& part = parts[static_cast<std::size_t>(j)];
    const ConstArrayView g(part.g.get());
    for (Eigen::Index i = 0; i < n; ++i) {
      const PetscInt row = border_[static_cast<std::size_t>(i)];
      if (owns(row)) sums(i, n + 2 * num_solutions + j) = std::sqrt(part.c) * g[row - first_];
    }
  }
  reduce(sums);
  T_ = sums.middleCols(n, num_solutions).transpose();
  const auto of_parts = sums.rightCols(num_parts);
  S_.compute(sums.leftCols(n) + sums.middleCols(n + num_solutions, num_solutions) * T_ +
             of_parts * of_parts.transpose());
}

void BorderedSystem::subtract_coupling(Vec x, Eigen::Ref<Eigen::VectorXd> y) {
  check(VecScatterBegin(scatter_.get(), x, needed_.get(), INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterEnd(scatter_.get(), x, needed_.get(), INSERT_VALUES, SCATTER_FORWARD));
  const ConstArrayView needed(needed_.get());
  for (const Entry& entry : C_) y[entry.row] -= entry.value * needed[entry.column];
}

void BorderedSystem::begin(Vec b) {
  part_of_rest_ = 1.0;
  if (!solutions_.empty()) return;  // the border passes on what it has
  PetscReal whole = 0.0, rest = 0.0;
  check(VecNorm(b, NORM_2, &whole));
  check(VecCopy(b, without_border_.get()));
  clear_border(without_border_.get());
  check(VecNorm(without_border_.get(), NORM_2, &rest));
  if (whole > 0.0) part_of_rest_ = rest / whole;
}

void BorderedSystem::apply(Vec r, Vec x) {
  check(VecCopy(r, without_border_.get()));
  clear_border(without_border_.get());
  check(PCApply(inner_.get(), without_border_.get(), x));
  Eigen::VectorXd y = Eigen::VectorXd::Zero(size());
  {
    const ConstArrayView entries(r);
    for (Eigen::Index i = 0; i < size(); ++i) {
      const PetscInt row = border_[static_cast<std::size_t>(i)];
      if (owns(row)) y[i] = entries[row - first_];
    }
  }
  subtract_coupling(x, y);
  sum_in_place(comm_, std::span(y.data(), border_.size()));
  y = S_.solve(y);
  const Eigen::VectorXd t = -(T_ * y);
  std::vector<Vec> solutions;
  for (const auto& solution : rotated_solutions_) solutions.push_back(solution.get());
  check(VecMAXPY(x, static_cast<PetscInt>(solutions.size()), t.data(), solutions.data()));
  const ArrayView entries(x);
  for (Eigen::Index i = 0; i < size(); ++i) {
    const PetscInt row = border_[static_cast<std::size_t>(i)];
    if (owns(row)) entries[row - first_] = y[i];
  }
}

PetscErrorCode BorderedSystem::apply_callback(PC pc, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] { static_cast<BorderedSystem*>(self)->apply(x, y); });
}

PetscErrorCode BorderedSystem::begin_callback(PC pc, KSP /*ksp*/, Vec b, Vec /*x*/) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] { static_cast<BorderedSystem*>(self)->begin(b); });
}

PetscErrorCode BorderedSystem::view_callback(PC pc, PetscViewer viewer) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return PCView(static_cast<BorderedSystem*>(self)->inner_.get(), viewer);
}

}  // namespace pliant
