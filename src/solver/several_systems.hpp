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

  struct Cost {
    int iterations = 0;
    double digits = 0.0;  ///< of the residual that lost the most
  };
  /// Solves until each residual has fallen to this part of what it is at 0, by at most `most` iterations. `r`: the
  /// residuals at the guesses, which are nullptr where they are 0; y is to be added to them. Returns what it took;
  /// nothing, with y undefined, if K is not made of blocks, or not positive definite along a direction, or there are
  /// too few iterations.
  std::optional<Cost> solve(Mat K, const Inverse& inverse, std::span<const Vec> r, std::span<const Vec> guesses,
                            std::span<const Vec> y, double part, int most);

 private:
  void open(const MatrixBlocks& blocks, Mat K);
  SeveralDoubles dot(std::span<const SeveralDoubles> a, std::span<const SeveralDoubles> b) const;

  PetscObjectId pattern_ = 0;  // that the following belongs to
  Halo halo_;
  std::vector<SeveralDoubles> x_, r_, z_, p_, Kp_;  // p_ with ghosts
};

}  // namespace pliant
