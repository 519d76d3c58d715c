/// A level of multigrid: its matrix and its smoother.
#pragma once

#include "base/several.hpp"
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
  std::vector<float> make_vector() const { return std::vector<float>(num_local_entries()); }
  std::size_t num_local_entries() const { return num_entries(halo_.num_local()); }
  std::size_t num_own_entries() const { return num_entries(halo_.num_owned()); }

  /// Takes the values of the matrix, and estimates the largest eigenvalue of D^-1 A. Returns false if that is not
  /// positive. Collective.
  bool take(const BlockSource& values);

  /// Vectors of numbers or of packs of them (T = float, SeveralFloats).
  template <class T>
  struct Work {
    explicit Work(std::size_t size) : b(size), x(size), r(size), step(size) {}
    std::vector<T> b, x, r, step;
  };
  /// Improves w.x for the right-hand side w.b, from zero or from what it is. Collective.
  template <class T>
  void smooth_from_zero(Work<T>& w) const {
    smooth(w, Start::zero);
  }
  template <class T>
  void smooth_further(Work<T>& w) const {
    smooth(w, Start::given);
  }
  /// w.r = w.b - A w.x for own nodes. Collective.
  template <class T>
  void residual(Work<T>& w) const;

 private:
  enum class Start { zero, given };
  std::size_t num_entries(int nodes) const {
    return static_cast<std::size_t>(nodes) * static_cast<std::size_t>(A_.height);
  }
  template <class T>
  std::span<T> own(std::span<T> x) const {
    return x.first(num_own_entries());
  }
  void invert_diagonal();
  double estimate_largest() const;
  template <class T>
  void smooth(Work<T>& w, Start start) const;

  Halo halo_;
  BlockCsr A_;
  std::vector<float> D_;  // inverse of the diagonal blocks
  double largest_ = 0.0;
};

}  // namespace pliant
