/// A preconditioner that belongs to the matrix of its last set-up: a factorization (MUMPS) or multigrid.
#pragma once

#include "multigrid/block_multigrid.hpp"
#include "petsc/handle.hpp"
#include "solver/linear_kind.hpp"
#include "solver/single_factorization.hpp"

#include <memory>
#include <optional>
#include <utility>

namespace pliant {

/// A factorization in single precision while that is accurate enough, then in double; multigrid if memory is too small,
/// or from the start. The factorization of a nearly symmetric matrix is its symmetric part's, half the work, while that
/// is near enough. Multigrid is BlockMultigrid where the matrix allows, otherwise PETSc's GAMG.
/// All methods are collective unless they only read.
class Factorization {
 public:
  enum class Kind {
    factors,
    multigrid,
    adaptive  ///< multigrid, until `refine` asks for factors
  };
  /// `P`: the prolongation to the finest level of multigrid, if there is one.
  Factorization(Symmetry symmetry, Kind kind, Mat P)
      : given_symmetry_(symmetry), given_kind_(kind), symmetry_(symmetry), kind_(kind), P_(shared(P)) {
    if (kind == Kind::factors) single_.emplace(symmetry);
  }

  void set_up(Mat K);
  /// What becomes of indefinite matrices in the next set-ups.
  void treat(Indefinite indefinite) { indefinite_ = indefinite; }
  void apply(Vec b, Vec x);
  /// The same for several vectors at once; false if the preconditioner is one of PETSc's.
  bool apply(std::span<const SeveralDoubles> b, std::span<SeveralDoubles> x);
  std::optional<PetscInt> negative_pivots() const;
  SetUp outcome() const { return outcome_; }
  double cost_of_set_up() const;
  void view(PetscViewer viewer) const;
  const char* name() const;
  /// Whether multigrid has taken the place of a factorization.
  bool is_replaced() const { return kind_ == Kind::factors && is_multigrid(); }
  bool uses_near_null_space() const { return kind_ != Kind::factors || is_multigrid(); }
  bool may_become_factors() const { return kind_ == Kind::adaptive; }
  bool is_of_symmetric_part() const { return single_ && symmetry_ == Symmetry::nearly_symmetric; }
  /// Makes all further set-ups more accurate; false if nothing better is available.
  bool refine();
  /// Makes the next set-up the same as the first one of a new object: no aggregates of another matrix, nothing refined.
  /// Multigrid that replaces a factorization for lack of memory stays.
  void forget();

 private:
  static Handle<Mat> shared(Mat P) {
    if (P != nullptr) check(PetscObjectReference(reinterpret_cast<PetscObject>(P)));
    return Handle<Mat>(P);
  }
  bool is_multigrid() const { return blocks_ != nullptr || multigrid_; }
  const Handle<PC>& other() const { return multigrid_ ? multigrid_ : double_; }
  void factorize(Mat K);
  void factorize_whole();
  /// Keeps the factors of K until the next set-up, although K changes: PETSc would factorize anew at the next solve.
  static void keep(PC pc) { check(PCSetReusePreconditioner(pc, PETSC_TRUE)); }
  void make_double(Mat K);
  void become_factors();
  void set_up_multigrid(Mat K);
  /// Works on a copy of K, since GAMG smooths with the matrix itself.
  void make_multigrid_of_petsc(Mat K);

  Symmetry given_symmetry_;
  Kind given_kind_;
  Symmetry symmetry_;
  Kind kind_;
  Handle<Mat> P_;
  // One of them.
  std::optional<SingleFactorization> single_;
  std::unique_ptr<BlockMultigrid> blocks_;
  Handle<PC> double_, multigrid_;
  PetscObjectId pattern_of_double_ = 0;
  Handle<Mat> of_multigrid_;
  PetscObjectId pattern_of_multigrid_ = 0;
  Indefinite indefinite_ = Indefinite::verified;
  SetUp outcome_ = SetUp::singular;
  int ordering_ = pord;
};

/// Cost of a set-up in iterations of the Krylov method where the preconditioner does not report its size.
inline constexpr double cost_of_usual_set_up = 16.0;
void use_algebraic_multigrid(PC pc);
/// A factorization by MUMPS in double precision.
void use_double_precision(PC pc, Symmetry symmetry);
/// `workspace`: beyond MUMPS's estimate [per cent].
void control_mumps(PC pc, Mat K, PetscInt workspace, int ordering = pord);
/// Sets up a preconditioner of PETSc's; a factorization that runs out of workspace is repeated with more.
SetUp set_up_with_workspace(PC pc, Mat K, int ordering = pord);
/// Number of negative pivots of PETSc's factorization LDL^T; nothing if it is another preconditioner.
std::optional<PetscInt> negative_pivots_of_petsc(PC pc);

}  // namespace pliant
