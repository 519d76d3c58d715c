/// Linear systems of one matrix with several right-hand sides.
#pragma once

#include "multigrid/matrix_blocks.hpp"
#include "petsc/handle.hpp"

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// Up to `num_several` systems K y = r by preconditioned conjugate gradients, each with coefficients of its own (Saad
/// 2003, Iterative Methods for Sparse Linear Systems, algorithm 9.1), side by side: matrix and preconditioner are read
/// once for all of them. Collective.
class SeveralSystems {
 public:
  /// x = about K^-1 b for own entries; false if that is not possible.
  using Inverse = std::function<bool(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x)>;

  /// Solves until each residual has fallen to its part of r, by at most `most` iterations; r and y are as many. Returns
  /// how many iterations it took; nothing, with y undefined, if K is not made of blocks, or not positive definite along
  /// a direction, or there are too few iterations.
  std::optional<int> solve(Mat K, const Inverse& inverse, std::span<const Vec> r, std::span<const Vec> y,
                           std::span<const double> parts, int most);

 private:
  void open(const MatrixBlocks& blocks, Mat K);
  SeveralDoubles dot(std::span<const SeveralDoubles> a, std::span<const SeveralDoubles> b) const;

  PetscObjectId pattern_ = 0;  // that the following belongs to
  Halo halo_;
  std::vector<SeveralDoubles> x_, r_, z_, p_, Kp_;  // p_ with ghosts
};

}  // namespace pliant
