/// The equation of a stage as Newton's method sees it: the residual r(q) = 0 (out-of-balance force), its Hessian
/// (tangent stiffness), and what helps to solve it.
#pragma once

#include "energy/rank_one.hpp"
#include "energy/term.hpp"
#include "fem/coarsening.hpp"
#include "fem/nodal_rotations.hpp"
#include "petsc/handle.hpp"
#include "time/stage.hpp"

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The fraction of the step at which a tetrahedron becomes flat (StageEquation::max_step()): how far solvers go.
inline constexpr double inversion_margin = 0.9;

/// The equation of a stage in unknowns xi (degrees of freedom). The configuration is a function q(xi) of them:
/// displacements of nodes, or those that constraints leave free, with pressures added to them. Stages are posed and
/// answered in configurations, `enter` and `leave` convert; everything else is in unknowns. Equations wrap one another,
/// and no caller needs to know which. All methods are collective and give every rank the same answer, NaN and infinity
/// included, so that no rank decides alone.
class StageEquation {
 public:
  virtual ~StageEquation() = default;

  /// Begins the stage `stage`, given in configurations, to which all following calls refer, and sets xi to the unknowns
  /// of q, a guess of its end. Returns the stage in unknowns; what it refers to is valid until the next call.
  virtual StagePoint enter(const StagePoint& stage, Vec q, Vec xi) = 0;
  /// q = the configuration at xi, which solves the stage. Unknowns that are not part of q are kept for the next guess.
  virtual void leave(Vec xi, Vec q) { check(VecCopy(xi, q)); }
  /// For a stage that was not solved: resets unknowns that are not part of q to those of the last solution.
  virtual void give_up() {}

  /// To be called before a stage is solved: freezes the coefficients of terms that refreeze at q, as the following
  /// calls see them. Between `enter` and this call the coefficients follow q, and there is no potential.
  virtual void freeze(Vec /*q*/) {}
  /// Freezes them again at a solution. Returns false, and does nothing, if coefficients may stay as they are: no term
  /// refreezes, and those frozen at the step's start stay within their bound at q (EnergyTerm::bound). Coefficients
  /// that exceed it refreeze too, until the next call of `freeze`. A stage is solved when its solution equals the q of
  /// the last call.
  virtual bool refreeze(Vec /*q*/) { return false; }
  /// Whether coefficients with a bound refreeze since the last call of `freeze`, because they have exceeded it.
  virtual bool exceeds_bound() const { return false; }
  /// Lets them refreeze from now on, as if they had.
  virtual void exceed_bound() {}
  /// f(q) of the terms that refreeze, with coefficients frozen at `at` [N]; leaves them frozen there.
  virtual void drag(Vec /*q*/, Vec /*at*/, Vec f) { check(VecZeroEntries(f)); }

  /// Sets the prescribed motion (Dirichlet boundary conditions), except for prescribed entries of q, to a fraction
  /// between the accepted state (0) and the end of the stage (1), where it is after `enter`. At a smaller fraction
  /// `max_step` and `max_step_to_wall` are those of displacements that come with the rest of it.
  virtual void set_prescribed_fraction(double /*fraction*/) {}
  /// q = the accepted state, with each free body moved rigidly as its inertia carries it; false, and q unchanged, if
  /// there is no such body.
  virtual bool move_rigidly(Vec /*q*/) { return false; }

  /// Which nodes follow an obstacle that has moved.
  enum class Followers {
    near,   ///< nodes close to it follow fully, others less with distance
    bodies  ///< all nodes, by the mean displacement of those nearest
  };
  /// q = the accepted state, with nodes displaced by the motion of obstacles that would otherwise have moved onto them.
  /// Returns false if no obstacle has moved close to a node.
  virtual bool follow_obstacles(Followers /*which*/, Vec /*q*/) { return false; }
  /// q = the accepted state, displaced as a whole by the mean displacement of the nodes whose prescribed entries in q
  /// move: what they would strike moves with them. Returns false if none moves.
  virtual bool follow_prescribed_nodes(Vec /*q*/) { return false; }

  /// Whether q, a solution or as far as a solve came, is to be the guess of another one: bodies have rotated so far
  /// that unknowns made for rotations near the guess lead no further, or do not show the forces on them. Collective.
  virtual bool is_far_from_guess(Vec /*q*/) { return false; }

  /// Phi(q) of the terms that are potentials [J], up to a constant of the stage; +inf where a barrier is crossed or a
  /// number is not finite.
  virtual double value(Vec q) = 0;
  /// r(q) [N], zero on prescribed entries; the gradient of `value` if is_potential().
  virtual void gradient(Vec q, Vec r) = 0;
  /// A zero matrix for the Hessian, with its near-null space if there is one.
  virtual Handle<Mat> make_hessian() const = 0;
  /// A coarse space of the unknowns for multigrid; nullopt if there is none.
  virtual std::optional<Coarsening> make_coarsening() const { return std::nullopt; }
  /// Rotations of the nodes whose displacements are unknowns, for corotated preconditioners; nullptr if the unknowns
  /// are of another kind, or the stiffness is constant (linear elasticity).
  virtual std::unique_ptr<NodalRotations> make_rotations() const { return nullptr; }
  /// The displacements of all nodes at the unknowns q, valid until the next call. Their unknowns come first on each
  /// rank.
  virtual Vec displacements(Vec q) { return q; }
  /// The unknowns from which the present ones were reached along a straight line; nullptr if there are none. Hessians
  /// may use stresses extrapolated along that line, which makes Newton's method converge as if stresses were unknowns
  /// too.
  virtual void extrapolate_from(Vec /*q*/) {}
  /// K = dr/dq [N/m] without its rank-one terms, or an approximation; rows and columns of prescribed entries are zero
  /// except for the diagonal.
  virtual void hessian(Vec q, Mat K, Projection projection) = 0;
  /// Lets the near-null space of K be the rigid motions of the bodies where they are at q.
  virtual void follow_rigid_motions(Vec /*q*/, Mat /*K*/) const {}
  /// The number of rank-one terms of the Hessian in addition to K.
  virtual std::size_t num_rank_one() const { return 0; }
  /// The rank-one terms at q; `parts` has num_rank_one() of them, with vectors of make_vector().
  virtual void rank_one_parts(Vec /*q*/, std::vector<RankOne>& /*parts*/) {}
  /// Drops what earlier evaluations have left behind and rounding can show, so that a run that is resumed here computes
  /// the same bits. Not collective.
  virtual void forget() {}
  /// The largest alpha for which q + alpha d crosses no barrier.
  virtual double max_step(Vec q, Vec d) = 0;
  /// Whether a term is a wall, a barrier that must not be jumped over (TermDeclaration::is_wall).
  virtual bool has_walls() const { return false; }
  /// Walls that a path meets: all, or those which only a path shows to be crossed (TermDeclaration::is_two_sided).
  enum class Walls { all, two_sided };
  /// The largest alpha for which q + alpha d crosses no such wall.
  virtual double max_step_to_wall(Vec /*q*/, Vec /*d*/, Walls /*which*/) {
    return std::numeric_limits<double>::infinity();
  }
  /// Sum over the terms of the norms of their forces, including those on prescribed entries [N]: the size of the forces
  /// that must balance, to which residuals are compared.
  virtual double force_scale(Vec q) = 0;
  /// Norm of the forces that would stop the bodies within the stage, M v0 / dt; 0 without inertia [N].
  virtual double inertia_scale() { return 0.0; }
  /// Size of the rounding errors in r at q [N].
  virtual double rounding_floor(Vec q) const = 0;

  /// The magnitude of the diagonal of K, as `hessian` left it last, in D: the scale of each unknown; anything where it
  /// is prescribed.
  virtual void size_of_diagonal(Mat K, Vec D) const { check(MatGetDiagonal(K, D)); }
  /// Properties of K at a stable solution.
  virtual PetscInt num_negative_pivots() const { return 0; }

  /// Whether a stage has no inertia and asks for an equilibrium, which need not be stable.
  virtual bool is_static() const { return false; }
  /// Names of the terms without a potential, each once; empty if r is the gradient of `value`.
  virtual std::vector<std::string> non_potentials() const = 0;
  bool is_potential() const { return non_potentials().empty(); }
  virtual Symmetry symmetry() const = 0;
  /// Where `symmetry` is nearly_symmetric: the rows and columns that are not symmetric, ascending, of all ranks and the
  /// same on each; empty if they are too many to be treated apart. Not collective.
  virtual std::vector<PetscInt> border() const { return {}; }

  /// One flag per owned entry (at least): whether it is prescribed.
  virtual const std::vector<char>& prescribed() const = 0;
  virtual PetscInt num_unknowns() const = 0;
  virtual MPI_Comm comm() const = 0;
  /// A zero vector of the unknowns.
  virtual Handle<Vec> make_vector() const = 0;
};

}  // namespace pliant
