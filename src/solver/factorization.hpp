/// A sparse factorization (MUMPS) as a preconditioner that stays usable: in single or double precision, or replaced.
#pragma once

#include "petsc/handle.hpp"
#include "solver/single_factorization.hpp"

#include <optional>
#include <utility>

namespace pliant {

/// A factorization in single precision while that is accurate enough, then in double; multigrid if memory is too small.
/// That of a nearly symmetric matrix is its symmetric part's, half the work, while that is near enough.
/// All methods are collective unless they only read.
class Factorization {
 public:
  explicit Factorization(Symmetry symmetry) : symmetry_(symmetry), single_(std::in_place, symmetry) {}

  void set_up(Mat K);
  void apply(Vec b, Vec x) { single_ ? single_->solve(b, x) : check(PCApply(other().get(), b, x)); }
  std::optional<PetscInt> negative_pivots() const;
  SetUp outcome() const { return outcome_; }
  double cost_of_set_up() const;
  void view(PetscViewer viewer) const;
  const char* name() const;
  bool is_multigrid() const { return static_cast<bool>(multigrid_); }
  bool is_of_symmetric_part() const { return single_ && symmetry_ == Symmetry::nearly_symmetric; }
  /// Makes all further set-ups more accurate; false if nothing better is available.
  bool refine();

 private:
  const Handle<PC>& other() const { return multigrid_ ? multigrid_ : double_; }
  void factorize(Mat K);
  void factorize_whole();
  /// Keeps the factors of K until the next set-up, although K changes: PETSc would factorize anew at the next solve.
  static void keep(PC pc) { check(PCSetReusePreconditioner(pc, PETSC_TRUE)); }
  void make_double(Mat K);
  /// Works on a copy of K: like a factorization, it belongs to the matrix of the last set-up.
  void make_multigrid(Mat K);

  Symmetry symmetry_;
  // One of them.
  std::optional<SingleFactorization> single_;
  Handle<PC> double_, multigrid_;
  PetscObjectId pattern_of_double_ = 0;
  Handle<Mat> of_multigrid_;
  PetscObjectId pattern_of_multigrid_ = 0;
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
