/// Algebraic multigrid for elastic bodies in single precision, as a preconditioner.
#pragma once

#include "base/several.hpp"
#include "multigrid/galerkin.hpp"
#include "multigrid/level.hpp"
#include "petsc/handle.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// A V-cycle of smoothed aggregation (Vanek, Mandel & Brezina 1996) over blocks of 3 x 3 and, on the coarser levels, of
/// 6 x 6: a rigid motion for each aggregate. The coarsest level is solved by every rank. Like a factorization it
/// belongs to the matrix of the last set-up, and to its near-null modes, which turn with the body; aggregates stay.
class BlockMultigrid {
 public:
  /// Multigrid for matrices with the pattern of K; nullptr if K is not made of blocks of 3 x 3, has no near-null modes,
  /// or cannot be coarsened. Collective.
  /// `P`: the prolongation to the first level from nodes that are those of a coarser level too; null: aggregates.
  static std::unique_ptr<BlockMultigrid> make(Mat K, Mat P = nullptr);

  /// Takes the values of K, of the same pattern. Returns false if a level is not positive definite. Collective.
  bool set_up(Mat K);
  /// x = an approximation of K^-1 b. Collective.
  void apply(Vec b, Vec x);
  /// The same for the own entries of several vectors at once. Collective.
  void apply(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x);

  int num_levels() const { return static_cast<int>(levels_.size()); }
  /// Entries of all matrices relative to those of the finest.
  double operator_complexity() const;

 private:
  template <class T>
  using Works = std::vector<Level::Work<T>>;  // of the levels
  enum class Depth { deeper, coarsest, hopeless };
  BlockMultigrid() = default;
  void add_level(Halo halo, BlockCsr pattern);
  /// Whether the level with these aggregates has a coarser one.
  static Depth depth_after(const Aggregates& aggregates, const Halo& halo);
  Modes inject(const BlockSource& values, const Modes& modes);
  /// Computes the matrix of level n + 1; returns its modes.
  Modes coarsen(std::size_t n, const BlockSource& values, Modes modes);
  const BlockSource& values_of(std::size_t level, const BlockSource& finest) const;
  bool factorize_coarsest(const BlockSource& values);
  template <class T>
  void cycle(std::size_t level, Works<T>& works);
  template <class T>
  void solve_coarsest(Level::Work<T>& work);

  std::vector<Level> levels_;  // finest first
  std::vector<Aggregates> aggregates_;
  std::optional<ProlongationRows> given_;                    // from the second level to the first
  std::vector<std::unique_ptr<GalerkinProduct>> transfers_;  // to the next level
  Works<float> work_;
  Works<SeveralFloats> several_;  // empty until they are needed
  struct Coarsest;
  struct Deleter {
    void operator()(Coarsest* coarsest) const;
  };
  std::unique_ptr<Coarsest, Deleter> coarsest_;
  double scale_ = 1.0;  // of the matrix, which is stored divided by it
};

}  // namespace pliant
