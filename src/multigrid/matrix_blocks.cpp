#include "multigrid/matrix_blocks.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {

void MatrixBlocks::Part::open(Mat of, PetscInt num_rows, std::vector<PetscInt> entries) {
  matrix_ = of;
  entries_ = std::move(entries);
  PetscInt n = 0;
  PetscBool is_done = PETSC_FALSE;
  check(MatGetRowIJ(matrix_, 0, PETSC_FALSE, PETSC_FALSE, &n, &offsets_, &columns_, &is_done));
  check(MatSeqAIJGetArrayRead(matrix_, &values_));
  if (!is_of_blocks(num_rows)) find_blocks(num_rows);
}

void MatrixBlocks::Part::close() {
  if (matrix_ == nullptr) return;
  PetscInt n = 0;
  PetscBool is_done = PETSC_FALSE;
  (void)MatSeqAIJRestoreArrayRead(matrix_, &values_);
  (void)MatRestoreRowIJ(matrix_, 0, PETSC_FALSE, PETSC_FALSE, &n, &offsets_, &columns_, &is_done);
}

bool MatrixBlocks::Part::is_of_blocks(PetscInt num_rows) const {
  for (PetscInt row = 0; row < num_rows; row += 3) {
    const PetscInt begin = offsets_[row], size = offsets_[row + 1] - begin;
    if (size % 3 != 0) return false;
    for (PetscInt k = 0; k < size; ++k) {
      const PetscInt first = entry(columns_[begin + k - k % 3]);
      if (entry(columns_[begin + k]) != first + k % 3 || first % 3 != 0) return false;
    }
    for (PetscInt c = 1; c < 3; ++c) {
      const PetscInt other = offsets_[row + c];
      if (offsets_[row + c + 1] - other != size) return false;
      if (!std::equal(columns_ + other, columns_ + other + size, columns_ + begin)) return false;
    }
  }
  return true;
}

void MatrixBlocks::Part::find_blocks(PetscInt num_rows) {
  begins_ = {0};
  std::vector<int> of_row;
  for (PetscInt row = 0; row < num_rows; row += 3) {
    of_row.clear();
    for (PetscInt k = offsets_[row]; k < offsets_[row + 3]; ++k) {
      of_row.push_back(static_cast<int>(entry(columns_[k]) / 3));
    }
    std::ranges::sort(of_row);
    nodes_.insert(nodes_.end(), of_row.begin(), std::unique(of_row.begin(), of_row.end()));
    begins_.push_back(static_cast<int>(nodes_.size()));
  }
}

double MatrixBlocks::Part::largest(PetscInt num_rows) const {
  double size = 0.0;
  if (matrix_ == nullptr) return size;
  for (PetscInt k = 0; k < offsets_[num_rows]; ++k) size = std::max(size, std::abs(values_[k]));
  return size;
}

std::size_t MatrixBlocks::Part::num_blocks(int row) const {
  const auto i = static_cast<std::size_t>(row);
  if (!begins_.empty()) return static_cast<std::size_t>(begins_[i + 1] - begins_[i]);
  return static_cast<std::size_t>(offsets_[3 * i + 1] - offsets_[3 * i]) / 3;
}

int MatrixBlocks::Part::node(int row, std::size_t k) const {
  const auto i = static_cast<std::size_t>(row);
  if (!begins_.empty()) return nodes_[static_cast<std::size_t>(begins_[i]) + k];
  return static_cast<int>(entry(columns_[static_cast<std::size_t>(offsets_[3 * i]) + 3 * k]) / 3);
}

void MatrixBlocks::Part::read(int row, std::size_t k, double factor, double* block) const {
  const PetscInt first = 3 * node(row, k);
  for (int r = 0; r < 3; ++r) {
    const PetscInt begin = offsets_[3 * row + r], end = offsets_[3 * row + r + 1];
    if (begins_.empty()) {
      const PetscScalar* const values = values_ + begin + 3 * static_cast<PetscInt>(k);
      for (int c = 0; c < 3; ++c) block[3 * c + r] = factor * values[c];
      continue;
    }
    for (int c = 0; c < 3; ++c) block[3 * c + r] = 0.0;
    const auto project = [this](PetscInt column) { return entry(column); };
    const PetscInt* at = std::ranges::lower_bound(columns_ + begin, columns_ + end, first, {}, project);
    for (; at != columns_ + end && entry(*at) < first + 3; ++at) {
      block[3 * (entry(*at) - first) + r] = factor * values_[at - columns_];
    }
  }
}

void MatrixBlocks::Part::add_products(int row, const SeveralDoubles* first, SeveralDoubles* sums) const {
  const PetscInt* const begins = offsets_ + 3 * static_cast<std::ptrdiff_t>(row);
  if (!begins_.empty()) {
    for (int r = 0; r < 3; ++r) {
      for (PetscInt k = begins[r]; k < begins[r + 1]; ++k) sums[r] += values_[k] * first[entry(columns_[k])];
    }
    return;
  }
  const PetscInt size = begins[1] - begins[0];
  const PetscInt* const columns = columns_ + begins[0];
  const PetscScalar* const values = values_ + begins[0];
  SeveralDoubles a = sums[0], b = sums[1], c = sums[2];
  for (PetscInt k = 0; k < size; k += 3) {
    const SeveralDoubles* const x = first + entry(columns[k]);
    for (PetscInt d = 0; d < 3; ++d) {
      a += values[k + d] * x[d];
      b += values[size + k + d] * x[d];
      c += values[2 * size + k + d] * x[d];
    }
  }
  sums[0] = a;
  sums[1] = b;
  sums[2] = c;
}

void MatrixBlocks::multiply(std::span<const SeveralDoubles> x, std::span<SeveralDoubles> y) const {
  for (int row = 0; row < num_rows_; ++row) {
    SeveralDoubles sums[3] = {0.0, 0.0, 0.0};
    own_.add_products(row, x.data(), sums);
    if (others_.is_open()) others_.add_products(row, x.data() + 3 * static_cast<std::ptrdiff_t>(num_rows_), sums);
    std::copy_n(sums, 3, y.begin() + 3 * static_cast<std::ptrdiff_t>(row));
  }
}

double MatrixBlocks::scale_to_one() {
  const PetscInt num_rows = 3 * num_rows_;
  double largest = maximum(comm_, std::max(own_.largest(num_rows), others_.largest(num_rows)));
  if (!(largest > 0.0)) largest = 1.0;
  factor_ = 1.0 / largest;
  return largest;
}

std::optional<MatrixBlocks> MatrixBlocks::of(Mat K) {
  MatrixBlocks blocks;
  blocks.comm_ = PetscObjectComm(reinterpret_cast<PetscObject>(K));
  PetscBool is_distributed = PETSC_FALSE, is_local = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(K), MATMPIAIJ, &is_distributed));
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(K), MATSEQAIJ, &is_local));
  if (!is_distributed && !is_local) return std::nullopt;
  PetscInt num_rows = 0, num_columns = 0;
  check(MatGetLocalSize(K, &num_rows, &num_columns));
  if (any_rank(blocks.comm_, num_rows % 3 != 0 || num_rows != num_columns)) return std::nullopt;
  blocks.num_rows_ = static_cast<int>(num_rows / 3);
  if (is_local) {
    blocks.own_.open(K, num_rows, {});
    return blocks;
  }
  Mat own = nullptr, others = nullptr;
  const PetscInt* map = nullptr;
  PetscInt num_others = 0;
  check(MatMPIAIJGetSeqAIJ(K, &own, &others, &map));
  check(MatGetSize(others, nullptr, &num_others));
  std::vector<PetscInt> entries;  // counted by ghosts
  for (PetscInt k = 0; k < num_others; ++k) {
    const PetscInt node = map[k] / 3;
    if (blocks.ghosts_.empty() || blocks.ghosts_.back() != node) blocks.ghosts_.push_back(node);
    entries.push_back(3 * static_cast<PetscInt>(blocks.ghosts_.size() - 1) + map[k] % 3);
  }
  blocks.own_.open(own, num_rows, {});
  blocks.others_.open(others, num_rows, std::move(entries));
  return blocks;
}

MatrixBlocks::MatrixBlocks(MatrixBlocks&& other) noexcept
    : comm_(other.comm_),
      num_rows_(other.num_rows_),
      own_(std::exchange(other.own_, {})),
      others_(std::exchange(other.others_, {})),
      ghosts_(std::move(other.ghosts_)),
      factor_(other.factor_) {}

MatrixBlocks::~MatrixBlocks() {
  own_.close();
  others_.close();
}

Halo MatrixBlocks::make_halo() const {
  return {comm_, num_rows_, ghosts_};
}

BlockCsr MatrixBlocks::pattern() const {
  BlockCsr A(3, 3);
  const auto take = [&A](const Part& part, int row, int first) {
    for (std::size_t k = 0; k < part.num_blocks(row); ++k) A.columns.push_back(first + part.node(row, k));
  };
  for (int row = 0; row < num_rows_; ++row) {
    take(own_, row, 0);
    if (others_.is_open()) take(others_, row, num_rows_);
    A.offsets.push_back(static_cast<int>(A.columns.size()));
  }
  return A;
}

void MatrixBlocks::read(int row, std::size_t k, double* block) const {
  const std::size_t num_own = own_.num_blocks(row);
  k < num_own ? own_.read(row, k, factor_, block) : others_.read(row, k - num_own, factor_, block);
}

}  // namespace pliant
