/// Linear systems whose matrix is symmetric but for a few rows and columns.
#pragma once

#include "energy/rank_one.hpp"
#include "energy/stage_equation.hpp"
#include "petsc/callback.hpp"
#include "petsc/handle.hpp"
#include "petsc/matrix_parts.hpp"

#include <eigen3/Eigen/Core>
#include <eigen3/Eigen/LU>
#include <span>
#include <vector>

namespace pliant {

/// The preconditioner of a bordered matrix: a large symmetric A, and the rows and columns of a few unknowns b (those of
/// a mechanism, StageEquation::border), from a preconditioner P ~ A^-1 that may be that of an earlier A:
///
///   K = [A B; C D],   S = D - C Z T,   Z T ~ A^-1 B,
///   x_b = S^-1 (r_b - C P r_a),   x_a = P r_a - Z T x_b.
///
/// The border is always that of the present K: a mechanism that moves fast does not age P, and P is the one of the soft
/// body alone. Z = P B V has as many columns as B has independent ones (six for each body of a mechanism that soft
/// cells touch), is found when P is, and rotates with the nodes; T are the coefficients of B in B V. Exact if P is and
/// B is that of the set-up, but for a rotation of each node (Golub & Van Loan, Matrix Computations, 3.2: block
/// elimination; Govaerts 2000, Numerical Methods for Bifurcations of Dynamical Equilibria, 3.6: bordered systems).
class BorderedSystem {
 public:
  /// Replaces the preconditioner of `ksp`, which becomes P. `border`: rows of K, ascending, of all ranks; `prescribed`:
  /// one flag per leading owned row that is that of the identity, but for its size. Both preconditioner and
  /// `rotations`, nullptr if P does not rotate, outlive the object. Collective.
  BorderedSystem(KSP ksp, Mat K, std::vector<PetscInt> border, const std::vector<char>& prescribed,
                 const NodalRotations* rotations);
  BorderedSystem(const BorderedSystem&) = delete;  // PETSc's objects point to it
  BorderedSystem& operator=(const BorderedSystem&) = delete;

  /// A of K, with the diagonal of K in the rows of b and the near-null space of K without them; for the set-up of P.
  /// Collective.
  Mat inner_matrix(Mat K);
  /// To be called after P was set up. Collective.
  void set_up(Mat K);
  /// To be called after K has changed, and after `set_up`. `parts`: rank-one terms in addition to K. Collective.
  void follow(Mat K, std::span<const RankOne> parts);
  /// The part of the last right-hand side that P has to do with: what is in the border alone goes with the first
  /// application. Not collective.
  double part_of_rest() const { return part_of_rest_; }
  /// Sets the entries of b to zero. Not collective.
  void clear_border(Vec x) const;

 private:
  /// An entry of K in one of its parts, which is entry (row, column) of a block. Rows and columns of b are counted in
  /// the border, those of A in the owned rows, and columns of C in `needed_`.
  struct Entry {
    std::size_t part = 0;
    PetscInt place = 0, row = 0, column = 0;
    double value = 0.0;
  };
  using Matrix = Eigen::MatrixXd;

  static PetscErrorCode apply_callback(PC pc, Vec x, Vec y);
  static PetscErrorCode begin_callback(PC pc, KSP ksp, Vec b, Vec x);
  static PetscErrorCode view_callback(PC pc, PetscViewer viewer);
  void apply(Vec r, Vec x);
  /// To be called before a system with the right-hand side b is solved.
  void begin(Vec b);
  bool owns(PetscInt row) const { return row >= first_ && row < last_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(border_.size()); }
  /// Finds the places of A, B, C and D in K.
  void find_places(Mat K);
  void make_inner(Mat K);
  /// Reads B, C and D.
  void read(Mat K);
  /// The sum of each number over the ranks.
  void reduce(Matrix& sums) const;
  /// y -= C x, on rows of this rank.
  void subtract_coupling(Vec x, Eigen::Ref<Eigen::VectorXd> y);
  void rotate(const std::vector<Handle<Vec>>& from, std::vector<Handle<Vec>>& to) const;

  MPI_Comm comm_;
  std::vector<PetscInt> border_;
  std::vector<char> is_prescribed_;
  const NodalRotations* rotations_;
  PetscInt first_ = 0, last_ = 0;
  Handle<PC> inner_;
  Handle<Vec> without_border_;
  PetscObjectId pattern_ = 0;
  Handle<Mat> A_;
  std::array<std::vector<EntryRun>, 2> A_from_K_;
  std::vector<Entry> B_, C_, D_;
  Handle<VecScatter> scatter_;
  Handle<Vec> needed_;  // entries of a vector that meet those of C, on this rank
  // B V and Z of the last set-up, and the same rotated with the nodes.
  std::vector<Handle<Vec>> directions_, solutions_, rotated_directions_, rotated_solutions_;
  Matrix T_;
  double part_of_rest_ = 1.0;
  Eigen::PartialPivLU<Matrix> S_;
};

}  // namespace pliant
