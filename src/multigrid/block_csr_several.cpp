#include "multigrid/block_csr_several.hpp"

#include "base/inline.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// A row of blocks times several vectors; `sum` has `height` entries.
template <int height, int width>
PLIANT_INLINE void several_times(const float* block, const SeveralFloats* x, SeveralFloats* sum) {
  for (int c = 0; c < width; ++c) {
    for (int r = 0; r < height; ++r) sum[r] += block[height * c + r] * x[c];
  }
}

template <int height, int width>
PLIANT_INLINE void row_times_several(const BlockCsr& A, int row, const SeveralFloats* x, SeveralFloats* sum) {
  // Two sums where one alone would wait for itself.
  SeveralFloats odd[height];
  for (int r = 0; r < height; ++r) sum[r] = odd[r] = 0.0F;
  const std::size_t end = A.end(row);
  std::size_t k = A.begin(row);
  const auto at = [&](std::size_t block) { return x + width * std::ptrdiff_t{A.columns[block]}; };
  for (; k + 1 < end; k += 2) {
    several_times<height, width>(A.block(k), at(k), sum);
    several_times<height, width>(A.block(k + 1), at(k + 1), odd);
  }
  if (k < end) several_times<height, width>(A.block(k), at(k), sum);
  for (int r = 0; r < height; ++r) sum[r] += odd[r];
}

}  // namespace

void residual(const BlockCsr& A, std::span<const SeveralFloats> x, std::span<const SeveralFloats> b,
              std::span<SeveralFloats> r) {
  with_block_size(A, [&]<int height, int width>() {
    SeveralFloats sum[height];
    for (std::size_t at = 0; at < r.size(); at += height) {
      row_times_several<height, width>(A, static_cast<int>(at / height), x.data(), sum);
      for (std::size_t c = 0; c < height; ++c) r[at + c] = b[at + c] - sum[c];
    }
  });
}

void smooth(const BlockCsr& A, std::span<const float> D, std::span<const SeveralFloats> x,
            std::span<const SeveralFloats> b, float keep, float take, std::span<SeveralFloats> p) {
  with_block_size(A, [&]<int height, int width>() {
    SeveralFloats left[height], step[height];
    for (std::size_t at = 0; at < p.size(); at += height) {
      row_times_several<height, width>(A, static_cast<int>(at / height), x.data(), left);
      for (std::size_t c = 0; c < height; ++c) {
        left[c] = b[at + c] - left[c];
        step[c] = 0.0F;
      }
      several_times<height, height>(&D[at * height], left, step);
      for (std::size_t c = 0; c < height; ++c) p[at + c] = keep * p[at + c] + take * step[c];
    }
  });
}

void scale_blocks(int size, std::span<const float> D, std::span<const SeveralFloats> b, float take,
                  std::span<SeveralFloats> p) {
  const auto scale = [&]<int height>() {
    SeveralFloats step[height];
    for (std::size_t at = 0; at < p.size(); at += height) {
      std::fill_n(step, height, SeveralFloats(0.0F));
      several_times<height, height>(&D[at * height], &b[at], step);
      for (std::size_t c = 0; c < height; ++c) p[at + c] = take * step[c];
    }
  };
  size == 3 ? scale.template operator()<3>() : scale.template operator()<6>();
}

void add_product(const BlockCsr& P, std::span<const SeveralFloats> c, std::span<SeveralFloats> x) {
  with_block_size(P, [&]<int height, int width>() {
    SeveralFloats sum[height];
    for (std::size_t at = 0; at < x.size(); at += height) {
      row_times_several<height, width>(P, static_cast<int>(at / height), c.data(), sum);
      for (std::size_t k = 0; k < height; ++k) x[at + k] += sum[k];
    }
  });
}

void multiply_transposed(const BlockCsr& P, std::span<const SeveralFloats> r, std::span<SeveralFloats> c) {
  std::ranges::fill(c, SeveralFloats(0.0F));
  with_block_size(P, [&]<int height, int width>() {
    for (std::size_t at = 0; at < r.size(); at += height) {
      const int row = static_cast<int>(at / height);
      for (std::size_t k = P.begin(row); k < P.end(row); ++k) {
        const float* const block = P.block(k);
        SeveralFloats* const to = &c[static_cast<std::size_t>(P.columns[k]) * width];
        for (int column = 0; column < width; ++column) {
          SeveralFloats sum = to[column];
          for (int i = 0; i < height; ++i) sum += block[column * height + i] * r[at + static_cast<std::size_t>(i)];
          to[column] = sum;
        }
      }
    }
  });
}

}  // namespace pliant
