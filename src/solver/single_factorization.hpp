/// A sparse factorization in single precision, as a preconditioner for equations in double precision.
#pragma once

#include "base/several.hpp"
#include "energy/term.hpp"
#include "petsc/handle.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// Outcome of a factorization, or of the set-up of another preconditioner.
enum class SetUp { sound, singular, out_of_memory };

/// What becomes of a matrix that its factorization in single precision finds indefinite.
enum class Indefinite {
  verified,  ///< it is factorized in double precision, which is kept if the matrix is definite there
  accepted   ///< it is changed anyway
};

/// Workspace of MUMPS beyond its estimate [per cent]: if pivoting needs more, four times as much, up to the last.
inline constexpr int first_workspace = 40, last_workspace = 10240;
/// Orderings (ICNTL(7)) that Debian's MUMPS has; METIS and SCOTCH are not among them.
inline constexpr int approximate_minimum_degree = 0, approximate_minimum_fill = 2, pord = 4;
/// PORD, its default ordering, aborts the process if all unknowns are coupled with all others (a rigid body, a single
/// cell).
inline constexpr PetscInt min_unknowns_of_pord = 100;

/// The outcome that MUMPS's INFOG(1) stands for.
SetUp outcome_of_mumps(int error);
/// Whether more workspace (ICNTL(14)) may help.
bool lacks_workspace(int error);

/// K = L D L^T, or L U if K is unsymmetric, by MUMPS in single precision; of a nearly symmetric K, its symmetric part
/// (K + K^T) / 2 = L D L^T. Factorizing and solving take half the time and memory of double precision, and cost one or
/// two more iterations of the Krylov method, which determines the accuracy of the solution. L D L^T is computed without
/// pivoting: small pivots make a poor preconditioner, but not a wrong one. The analysis is done once, as K keeps its
/// pattern. All methods are collective.
class SingleFactorization {
 public:
  explicit SingleFactorization(Symmetry symmetry);
  ~SingleFactorization();
  SingleFactorization(SingleFactorization&&) noexcept;
  SingleFactorization& operator=(SingleFactorization&&) noexcept;

  /// Factorizes K, an assembled matrix distributed by rows, and replaces the previous factors. Repeated with more
  /// workspace if necessary. `singular` means singular in single precision.
  SetUp factorize(Mat K);
  /// x = K^-1 b, approximately, after a successful `factorize`.
  void solve(Vec b, Vec x);
  /// The same for the own entries of several vectors at once; false if that fails.
  bool solve(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x);
  /// What MUMPS reports on the last factorization.
  struct Size {
    double entries = 0.0;  ///< of the factors, over all ranks
    double flops = 0.0;    ///< of the elimination
    int ordering = 0;      ///< as ICNTL(7)
  };
  Size size() const;
  /// Number of negative pivots of L D L^T in single precision; 0 where they say nothing about K: unless it is
  /// symmetric.
  PetscInt negative_pivots() const;

 private:
  struct Mumps;

  void analyse(Mat K);
  /// The entries of K, divided by the largest.
  void set_values(Mat K);
  bool is_kept(PetscInt row, PetscInt column) const { return !is_symmetric(symmetry_) || column >= row; }
  /// MUMPS adds the two halves of a nearly symmetric K.
  double weight(PetscInt row, PetscInt column) const {
    return symmetry_ == Symmetry::nearly_symmetric && row != column ? 0.5 : 1.0;
  }
  /// Gives MUMPS arrays for so many right-hand sides.
  void set_num_sides(std::size_t number);
  void gather_solution(std::size_t side, Vec x);

  Symmetry symmetry_;
  std::unique_ptr<Mumps> mumps_;
  PetscObjectId analysed_ = 0;       // pattern_id of the analysed matrix
  std::vector<int> rows_, columns_;  // of the entries, counted from 1
  std::vector<float> values_;
  double scale_ = 1.0;
  // Right-hand side and solution; with several ranks the solution lies where the pivots are.
  std::vector<int> rhs_rows_, solution_rows_;
  std::vector<float> rhs_, solution_;
  Handle<Vec> pivots_, gathered_;
  Handle<VecScatter> to_owners_;
};

}  // namespace pliant
