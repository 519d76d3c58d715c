#include "multigrid/matrix_blocks.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {

void MatrixBlocks::Part::open(Mat of) {
  matrix = of;
  PetscInt n = 0;
  PetscBool is_done = PETSC_FALSE;
  check(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &n, &offsets, &columns, &is_done));
  check(MatSeqAIJGetArrayRead(matrix, &values));
}

void MatrixBlocks::Part::close() {
  if (matrix == nullptr) return;
  PetscInt n = 0;
  PetscBool is_done = PETSC_FALSE;
  (void)MatSeqAIJRestoreArrayRead(matrix, &values);
  (void)MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &n, &offsets, &columns, &is_done);
}

bool MatrixBlocks::Part::is_of_blocks(PetscInt num_rows) const {
  for (PetscInt row = 0; row < num_rows; row += 3) {
    const PetscInt begin = offsets[row], size = offsets[row + 1] - begin;
    if (size % 3 != 0) return false;
    for (PetscInt k = 0; k < size; ++k) {
      if (columns[begin + k] != columns[begin + k - k % 3] + k % 3 || columns[begin + k - k % 3] % 3 != 0) return false;
    }
    for (PetscInt c = 1; c < 3; ++c) {
      const PetscInt other = offsets[row + c];
      if (offsets[row + c + 1] - other != size) return false;
      for (PetscInt k = 0; k < size; ++k) {
        if (columns[other + k] != columns[begin + k]) return false;
      }
    }
  }
  return true;
}

double MatrixBlocks::Part::largest(PetscInt num_rows) const {
  double size = 0.0;
  if (matrix == nullptr) return size;
  for (PetscInt k = 0; k < offsets[num_rows]; ++k) size = std::max(size, std::abs(values[k]));
  return size;
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
  bool is_of_blocks = num_rows % 3 == 0 && num_rows == num_columns;
  blocks.num_rows_ = static_cast<int>(num_rows / 3);
  if (is_local) {
    blocks.own_.open(K);
  } else {
    Mat own = nullptr, others = nullptr;
    const PetscInt* map = nullptr;
    PetscInt num_others = 0;
    check(MatMPIAIJGetSeqAIJ(K, &own, &others, &map));
    blocks.own_.open(own);
    blocks.others_.open(others);
    check(MatGetSize(others, nullptr, &num_others));
    is_of_blocks = is_of_blocks && num_others % 3 == 0;
    for (PetscInt k = 0; is_of_blocks && k < num_others; k += 3) {
      is_of_blocks = map[k] % 3 == 0 && map[k + 1] == map[k] + 1 && map[k + 2] == map[k] + 2;
      blocks.ghosts_.push_back(map[k] / 3);
    }
    is_of_blocks = is_of_blocks && blocks.others_.is_of_blocks(num_rows);
  }
  is_of_blocks = is_of_blocks && blocks.own_.is_of_blocks(num_rows);
  if (any_rank(blocks.comm_, !is_of_blocks)) return std::nullopt;
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
    const PetscInt* const columns = part.columns + part.offsets[3 * row];
    for (std::size_t k = 0; k < part.num_blocks(row); ++k) {
      A.columns.push_back(first + static_cast<int>(columns[3 * k] / 3));
    }
  };
  for (int row = 0; row < num_rows_; ++row) {
    take(own_, row, 0);
    if (others_.matrix != nullptr) take(others_, row, num_rows_);
    A.offsets.push_back(static_cast<int>(A.columns.size()));
  }
  return A;
}

void MatrixBlocks::read(int row, std::size_t k, double* block) const {
  const std::size_t num_own = own_.num_blocks(row);
  const Part& part = k < num_own ? own_ : others_;
  const std::size_t at = k < num_own ? k : k - num_own;
  for (int r = 0; r < 3; ++r) {
    const PetscScalar* const values = part.values + part.offsets[3 * row + r] + 3 * at;
    for (int c = 0; c < 3; ++c) block[3 * c + r] = factor_ * values[c];
  }
}

}  // namespace pliant
