/// Products of matrices of small blocks with several vectors at once.
#pragma once

#include "base/several.hpp"
#include "multigrid/block_csr.hpp"

#include <span>

namespace pliant {

/// As the functions of block_csr.hpp, for several vectors, in half the time of one after another.
void residual(const BlockCsr& A, std::span<const SeveralFloats> x, std::span<const SeveralFloats> b,
              std::span<SeveralFloats> r);
void smooth(const BlockCsr& A, std::span<const float> D, std::span<const SeveralFloats> x,
            std::span<const SeveralFloats> b, float keep, float take, std::span<SeveralFloats> p);
void scale_blocks(int size, std::span<const float> D, std::span<const SeveralFloats> b, float take,
                  std::span<SeveralFloats> p);
void add_product(const BlockCsr& P, std::span<const SeveralFloats> c, std::span<SeveralFloats> x);
void multiply_transposed(const BlockCsr& P, std::span<const SeveralFloats> r, std::span<SeveralFloats> c);

}  // namespace pliant
