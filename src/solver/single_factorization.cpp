#include "solver/single_factorization.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/matrix_pattern.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <smumps_c.h>
#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr int job_start = -1, job_end = -2, job_analyse = 1, job_factorize = 2, job_solve = 3;
constexpr int num_controls = 60;

int num_ranks(PetscObject object) {
  int size = 0;
  check_mpi(MPI_Comm_size(PetscObjectComm(object), &size));
  return size;
}

}  // namespace

bool lacks_workspace(int error) {
  // Workspace of the factors (-8, -9), of the solution (-11, -14), of messages (-17, -20).
  constexpr std::array codes{-8, -9, -11, -14, -15, -17, -18, -20};
  return std::ranges::find(codes, error) != codes.end();
}

SetUp outcome_of_mumps(int error) {
  if (error >= 0) return SetUp::sound;
  // The system has no more memory, for the analysis (-5, -7) or the factors (-13), or ICNTL(23) forbids it (-19).
  constexpr std::array codes{-5, -7, -13, -19};
  const bool lacks_memory = lacks_workspace(error) || std::ranges::find(codes, error) != codes.end();
  return lacks_memory ? SetUp::out_of_memory : SetUp::singular;
}

struct SingleFactorization::Mumps {
  SMUMPS_STRUC_C id{};

  Mumps(MPI_Comm comm, int symmetry) {
    id.job = job_start;
    id.par = 1;
    id.sym = symmetry;
    id.comm_fortran = MPI_Comm_c2f(comm);
    smumps_c(&id);
  }
  ~Mumps() {
    int is_finalized = 0;
    if (MPI_Finalized(&is_finalized) == MPI_SUCCESS && is_finalized == 0) run(job_end);
  }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  /// Control parameters as MUMPS's manual counts them, from 1.
  int& icntl(int number) { return id.icntl[number - 1]; }
  int infog(int number) const { return id.infog[number - 1]; }
  int run(int job) {
    id.job = job;
    smumps_c(&id);
    return infog(1);
  }
};

SingleFactorization::SingleFactorization(Symmetry symmetry) : symmetry_(symmetry) {}
SingleFactorization::~SingleFactorization() = default;
SingleFactorization::SingleFactorization(SingleFactorization&&) noexcept = default;
SingleFactorization& SingleFactorization::operator=(SingleFactorization&&) noexcept = default;

void SingleFactorization::analyse(Mat K) {
  mumps_.reset();
  gathered_ = {};
  analysed_ = pattern_id(K);
  rows_.clear();
  columns_.clear();
  rhs_rows_.clear();
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(K));
  PetscInt n = 0, begin = 0, end = 0;
  check(MatGetSize(K, &n, nullptr));
  check(MatGetOwnershipRange(K, &begin, &end));
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    check(MatGetRow(K, row, &count, &columns, nullptr));
    for (const PetscInt column : std::span(columns, static_cast<std::size_t>(count))) {
      if (!is_kept(row, column)) continue;
      rows_.push_back(static_cast<int>(row + 1));
      columns_.push_back(static_cast<int>(column + 1));
    }
    check(MatRestoreRow(K, row, &count, &columns, nullptr));
    rhs_rows_.push_back(static_cast<int>(row + 1));
  }
  values_.resize(rows_.size());
  const bool is_distributed = num_ranks(reinterpret_cast<PetscObject>(K)) > 1;

  // SYM = 1, "positive definite", means L D L^T without pivoting: negative pivots are counted, not rejected.
  mumps_ = std::make_unique<Mumps>(comm, symmetry_ == Symmetry::unsymmetric ? 0 : 1);
  auto& id = mumps_->id;
  for (const int output : {1, 2, 3}) mumps_->icntl(output) = -1;
  mumps_->icntl(4) = 0;
  mumps_->icntl(7) = n < min_unknowns_of_pord ? approximate_minimum_degree : pord;
  mumps_->icntl(13) = 1;  // no ScaLAPACK at the root: its pivots would be missing from the inertia
  mumps_->icntl(14) = first_workspace;
  for (int number = 1; number <= num_controls; ++number) {
    PetscInt value = 0;
    PetscBool is_given = PETSC_FALSE;
    check(PetscOptionsGetInt(nullptr, nullptr, fmt::format("-mat_mumps_icntl_{}", number).c_str(), &value, &is_given));
    if (is_given) mumps_->icntl(number) = static_cast<int>(value);
  }
  mumps_->icntl(18) = 3;                        // each rank has its rows
  mumps_->icntl(20) = is_distributed ? 10 : 0;  // and its part of the right-hand side
  mumps_->icntl(21) = is_distributed ? 1 : 0;   // the solution lies where the pivots are
  id.n = static_cast<int>(n);
  id.nnz_loc = static_cast<MUMPS_INT8>(rows_.size());
  id.irn_loc = rows_.data();
  id.jcn_loc = columns_.data();
  id.a_loc = values_.data();
  if (is_distributed) {
    id.nloc_rhs = id.lrhs_loc = static_cast<int>(rhs_rows_.size());
    id.irhs_loc = rhs_rows_.data();
  } else {
    id.lrhs = static_cast<int>(n);
  }
}

void SingleFactorization::set_values(Mat K) {
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(K, &begin, &end));
  std::vector<double> exact;
  exact.reserve(values_.size());
  double largest = 0.0;
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    check(MatGetRow(K, row, &count, &columns, &values));
    for (PetscInt k = 0; k < count; ++k) {
      if (!is_kept(row, columns[k])) continue;
      exact.push_back(weight(row, columns[k]) * values[k]);
      largest = std::max(largest, std::abs(values[k]));
    }
    check(MatRestoreRow(K, row, &count, &columns, &values));
  }
  largest = maximum(PetscObjectComm(reinterpret_cast<PetscObject>(K)), largest);
  scale_ = largest > 0.0 ? largest : 1.0;
  std::ranges::transform(exact, values_.begin(), [&](double x) { return static_cast<float>(x / scale_); });
}

SetUp SingleFactorization::factorize(Mat K) {
  const bool is_first = mumps_ == nullptr || pattern_id(K) != analysed_;
  if (is_first) analyse(K);
  set_values(K);
  if (is_first && mumps_->run(job_analyse) < 0) {
    const SetUp outcome = outcome_of_mumps(mumps_->infog(1));
    mumps_.reset();
    return outcome;
  }
  int error = mumps_->run(job_factorize);
  for (int workspace = first_workspace; lacks_workspace(error) && workspace <= last_workspace; workspace *= 4) {
    mumps_->icntl(14) = workspace;
    error = mumps_->run(job_factorize);
  }
  if (num_ranks(reinterpret_cast<PetscObject>(K)) > 1) {
    const int size = error >= 0 ? mumps_->id.info[22] : 0;  // above 0 it is a warning, and there are factors
    solution_rows_.resize(static_cast<std::size_t>(size));
    mumps_->id.lsol_loc = size;
    mumps_->id.isol_loc = solution_rows_.data();
    to_owners_ = {};
  }
  return outcome_of_mumps(error);
}

void SingleFactorization::set_num_sides(std::size_t number) {
  rhs_.resize(number * rhs_rows_.size());
  solution_.resize(number * solution_rows_.size());
  mumps_->id.nrhs = static_cast<int>(number);
  mumps_->id.rhs = mumps_->id.rhs_loc = rhs_.data();
  mumps_->id.sol_loc = solution_.data();
}

void SingleFactorization::gather_solution(std::size_t side, Vec x) {
  if (!to_owners_) {
    std::vector<PetscInt> rows(solution_rows_.begin(), solution_rows_.end());
    for (PetscInt& row : rows) --row;
    const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(x));
    const auto size = static_cast<PetscInt>(rows.size());
    check(VecCreateMPI(comm, size, PETSC_DETERMINE, pivots_.out()));
    Handle<IS> owners;
    check(ISCreateGeneral(comm, size, rows.data(), PETSC_COPY_VALUES, owners.out()));
    check(VecScatterCreate(pivots_.get(), nullptr, x, owners.get(), to_owners_.out()));
  }
  {
    const ArrayView values(pivots_.get());
    const std::size_t size = values.span().size();
    std::copy_n(solution_.begin() + static_cast<std::ptrdiff_t>(side * size), size, values.span().begin());
  }
  check(VecScatterBegin(to_owners_.get(), pivots_.get(), x, INSERT_VALUES, SCATTER_FORWARD));
  check(VecScatterEnd(to_owners_.get(), pivots_.get(), x, INSERT_VALUES, SCATTER_FORWARD));
}

void SingleFactorization::solve(Vec b, Vec x) {
  PetscReal size = 0.0;
  check(VecNorm(b, NORM_INFINITY, &size));
  if (!(size > 0.0)) {
    check(VecCopy(b, x));
    return;
  }
  set_num_sides(1);
  {
    const ConstArrayView values(b);
    std::ranges::transform(values.span(), rhs_.begin(), [&](double value) { return static_cast<float>(value / size); });
  }
  if (mumps_->run(job_solve) < 0) {
    check(VecSet(x, NAN));  // the Krylov method breaks down
    return;
  }
  if (num_ranks(reinterpret_cast<PetscObject>(x)) > 1) {
    gather_solution(0, x);
  } else {
    const ArrayView values(x);
    std::ranges::copy(rhs_, values.span().begin());
  }
  check(VecScale(x, size / scale_));
}

bool SingleFactorization::solve(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x) {
  const auto comm = MPI_Comm_f2c(mumps_->id.comm_fortran);
  set_num_sides(num_several);
  SeveralDoubles size(0.0);
  for (const SeveralDoubles& entry : b) size = std::experimental::max(size, std::experimental::abs(entry));
  for (std::size_t side = 0; side < num_several; ++side) {
    const double largest = maximum(comm, static_cast<double>(size[side]));
    size[side] = largest > 0.0 ? largest : 1.0;
    for (std::size_t i = 0; i < b.size(); ++i) rhs_[side * b.size() + i] = static_cast<float>(b[i][side] / size[side]);
  }
  if (mumps_->run(job_solve) < 0) return false;
  const bool is_distributed = mumps_->icntl(21) == 1;
  if (is_distributed && !gathered_) {
    check(VecCreateMPI(comm, static_cast<PetscInt>(x.size()), PETSC_DETERMINE, gathered_.out()));
  }
  for (std::size_t side = 0; side < num_several; ++side) {
    const double by = size[side] / scale_;
    if (!is_distributed) {
      for (std::size_t i = 0; i < x.size(); ++i) x[i][side] = by * rhs_[side * x.size() + i];
      continue;
    }
    gather_solution(side, gathered_.get());
    const ConstArrayView values(gathered_.get());
    for (std::size_t i = 0; i < x.size(); ++i) x[i][side] = by * values.span()[i];
  }
  return true;
}

SingleFactorization::Size SingleFactorization::size() const {
  // MUMPS reports a large number of entries in millions, with a minus sign.
  const double entries = mumps_->infog(29);
  return {entries < 0.0 ? -1e6 * entries : entries, mumps_->id.rinfog[2], mumps_->infog(7)};
}

PetscInt SingleFactorization::negative_pivots() const {
  return is_symmetric(symmetry_) ? mumps_->infog(12) : 0;
}

}  // namespace pliant
