#include "multigrid/block_csr.hpp"

#include "base/inline.hpp"

#include <algorithm>

#include <experimental/simd>

namespace pliant {
namespace {

namespace stdx = std::experimental;

/// A column of a block, and what lies behind it.
template <int height>
using Column = stdx::simd<float, stdx::simd_abi::deduce_t<float, height == 3 ? 4 : 8>>;

template <int height>
PLIANT_INLINE Column<height> load(const float* from) {
  return Column<height>(from, stdx::element_aligned);
}

template <int height>
PLIANT_INLINE void store(const Column<height>& column, float* to) {
  alignas(32) float lanes[Column<height>::size()];
  column.copy_to(lanes, stdx::element_aligned);
  std::copy_n(lanes, height, to);
}

/// A block times a vector, added.
template <int height, int width>
PLIANT_INLINE Column<height> times(const float* block, const float* x, Column<height> sum) {
  for (int c = 0; c < width; ++c) sum += load<height>(block + height * c) * x[c];
  return sum;
}

/// A row of blocks times a vector.
template <int height, int width>
PLIANT_INLINE Column<height> row_times(const BlockCsr& A, int row, const float* x) {
  Column<height> even(0.0F), odd(0.0F);
  const std::size_t end = A.end(row);
  const int* const columns = A.columns.data();
  const float* const values = A.values.data();
  constexpr std::size_t size = std::size_t{height} * width;
  std::size_t k = A.begin(row);
  for (; k + 1 < end; k += 2) {
    even = times<height, width>(values + k * size, x + width * std::ptrdiff_t{columns[k]}, even);
    odd = times<height, width>(values + (k + 1) * size, x + width * std::ptrdiff_t{columns[k + 1]}, odd);
  }
  if (k < end) even = times<height, width>(values + k * size, x + width * std::ptrdiff_t{columns[k]}, even);
  return even + odd;
}

}  // namespace

void multiply(const BlockCsr& A, std::span<const float> x, std::span<float> y) {
  with_block_size(A, [&]<int height, int width>() {
    const int n = static_cast<int>(y.size()) / height;
    for (int i = 0; i < n; ++i) {
      store<height>(row_times<height, width>(A, i, x.data()), &y[static_cast<std::size_t>(i) * height]);
    }
  });
}

void residual(const BlockCsr& A, std::span<const float> x, std::span<const float> b, std::span<float> r) {
  multiply(A, x, r);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = b[i] - r[i];
}

void smooth(const BlockCsr& A, std::span<const float> D, std::span<const float> x, std::span<const float> b, float keep,
            float take, std::span<float> p) {
  with_block_size(A, [&]<int height, int width>() {
    const int n = static_cast<int>(p.size()) / height;
    for (int i = 0; i < n; ++i) {
      const std::size_t at = static_cast<std::size_t>(i) * height;
      float left[height], step[height];
      store<height>(row_times<height, width>(A, i, x.data()), left);
      for (int c = 0; c < height; ++c) left[c] = b[at + static_cast<std::size_t>(c)] - left[c];
      store<height>(times<height, height>(&D[at * height], left, Column<height>(0.0F)), step);
      for (int c = 0; c < height; ++c) {
        float& entry = p[at + static_cast<std::size_t>(c)];
        entry = keep * entry + take * step[c];
      }
    }
  });
}

void scale_blocks(int size, std::span<const float> D, std::span<const float> b, float take, std::span<float> p) {
  const auto scale = [&]<int height>() {
    for (std::size_t at = 0; at < p.size(); at += height) {
      store<height>(times<height, height>(&D[at * height], &b[at], Column<height>(0.0F)) * take, &p[at]);
    }
  };
  size == 3 ? scale.template operator()<3>() : scale.template operator()<6>();
}

void add_product(const BlockCsr& P, std::span<const float> c, std::span<float> x) {
  with_block_size(P, [&]<int height, int width>() {
    const int n = static_cast<int>(x.size()) / height;
    for (int i = 0; i < n; ++i) {
      float sum[height];
      store<height>(row_times<height, width>(P, i, c.data()), sum);
      for (int k = 0; k < height; ++k) x[static_cast<std::size_t>(i * height + k)] += sum[k];
    }
  });
}

void multiply_transposed(const BlockCsr& P, std::span<const float> r, std::span<float> c) {
  std::ranges::fill(c, 0.0F);
  with_block_size(P, [&]<int height, int width>() {
    const int n = static_cast<int>(r.size()) / height;
    for (int i = 0; i < n; ++i) {
      const float* const from = &r[static_cast<std::size_t>(i) * height];
      for (std::size_t k = P.begin(i); k < P.end(i); ++k) {
        const float* const block = P.block(k);
        float* const to = &c[static_cast<std::size_t>(P.columns[k]) * width];
        for (int column = 0; column < width; ++column) {
          float sum = 0.0F;
          for (int row = 0; row < height; ++row) sum += block[column * height + row] * from[row];
          to[column] += sum;
        }
      }
    }
  });
}

}  // namespace pliant
