/// Sparse matrices of small dense blocks, in single precision, and their products.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace pliant {

/// Rows of blocks (compressed sparse rows). A row and a column of blocks belong to a node each; columns count as a Halo
/// does, own nodes first. Blocks are stored column by column, one after another.
struct BlockCsr {
  BlockCsr() = default;
  BlockCsr(int rows, int columns_of_block) : height(rows), width(columns_of_block) {}

  int height = 0, width = 0;  ///< of a block: 3 x 3, 3 x 6 or 6 x 6
  std::vector<int> offsets{0};
  std::vector<int> columns;
  std::vector<float> values;  ///< and `padding` numbers more

  /// Packs that read a column of a block may read beyond it.
  static constexpr std::size_t padding = 8;

  int num_rows() const { return static_cast<int>(offsets.size()) - 1; }
  std::size_t begin(int row) const { return static_cast<std::size_t>(offsets[static_cast<std::size_t>(row)]); }
  std::size_t end(int row) const { return begin(row + 1); }
  std::size_t block_size() const { return static_cast<std::size_t>(height) * static_cast<std::size_t>(width); }
  std::span<const int> columns_of(int row) const { return {columns.data() + begin(row), end(row) - begin(row)}; }
  const float* block(std::size_t k) const { return values.data() + k * block_size(); }
  float* block(std::size_t k) { return values.data() + k * block_size(); }
  void allocate() { values.assign(columns.size() * block_size() + padding, 0.0F); }
};

/// Calls `body` with height and width of the blocks as constants.
template <class Body>
void with_block_size(const BlockCsr& A, Body body) {
  if (A.height == 3 && A.width == 3) return body.template operator()<3, 3>();
  if (A.height == 3) return body.template operator()<3, 6>();
  return body.template operator()<6, 6>();
}

/// y = A x for the rows of y, all or the first ones. x has ghosts.
void multiply(const BlockCsr& A, std::span<const float> x, std::span<float> y);
/// r = b - A x.
void residual(const BlockCsr& A, std::span<const float> x, std::span<const float> b, std::span<float> r);
/// p = keep p + take D (b - A x), where D holds one block for each row: a step of a Chebyshev iteration.
void smooth(const BlockCsr& A, std::span<const float> D, std::span<const float> x, std::span<const float> b, float keep,
            float take, std::span<float> p);
/// p = take D b.
void scale_blocks(int size, std::span<const float> D, std::span<const float> b, float take, std::span<float> p);
/// x += P c for the rows of x. c has ghosts.
void add_product(const BlockCsr& P, std::span<const float> c, std::span<float> x);
/// c = P^T r over the rows of r; c has ghosts, which get the part of this rank too.
void multiply_transposed(const BlockCsr& P, std::span<const float> r, std::span<float> c);

}  // namespace pliant
