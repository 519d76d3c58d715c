/// A level of multigrid: its matrix and its smoother.
#pragma once

#include "multigrid/halo.hpp"
#include "multigrid/matrix_blocks.hpp"

#include <vector>

namespace pliant {

/// Smooths by Chebyshev iterations of D^-1 A, with the diagonal blocks D (Adams et al. 2003, "Parallel multigrid
/// smoothing: polynomial versus Gauss-Seidel"). Vectors hold own nodes and ghosts.
class Level {
 public:
  Level(Halo halo, BlockCsr pattern);

  const Halo& halo() const { return halo_; }
  const BlockCsr& matrix() const { return A_; }
  std::span<const float> inverse_diagonal() const { return D_; }
  double largest_eigenvalue() const { return largest_; }
  std::vector<float> make_vector() const { return std::vector<float>(num_entries(halo_.num_local())); }
  std::size_t num_own_entries() const { return num_entries(halo_.num_owned()); }

  /// Takes the values of the matrix, and estimates the largest eigenvalue of D^-1 A. Returns false if that is not
  /// positive. Collective.
  bool take(const BlockSource& values);

  /// Improves x, from zero or from what it is. Collective.
  void smooth_from_zero(std::span<const float> b, std::span<float> x) { smooth(b, x, Start::zero); }
  void smooth_further(std::span<const float> b, std::span<float> x) { smooth(b, x, Start::given); }
  /// r = b - A x for own nodes. Collective.
  void residual(std::span<const float> b, std::span<float> x, std::span<float> r) const;

 private:
  enum class Start { zero, given };
  std::size_t num_entries(int nodes) const {
    return static_cast<std::size_t>(nodes) * static_cast<std::size_t>(A_.height);
  }
  std::span<float> own(std::span<float> x) const { return x.first(num_own_entries()); }
  std::span<const float> own(std::span<const float> x) const { return x.first(num_own_entries()); }
  void invert_diagonal();
  double estimate_largest() const;
  void smooth(std::span<const float> b, std::span<float> x, Start start);

  Halo halo_;
  BlockCsr A_;
  std::vector<float> D_;  // inverse of the diagonal blocks
  double largest_ = 0.0;
  std::vector<float> step_;
};

}  // namespace pliant
