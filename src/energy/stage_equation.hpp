/// What Newton's method asks of a stage: r(q) = 0 and what helps to solve it.
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

  /// Begins the stage `stage` of configurations, of which all following calls speak, and makes xi the unknowns of q, a
  /// guess of its end. Returns the stage of the unknowns; what it refers to lives until the next call.
  virtual StagePoint enter(const StagePoint& stage, Vec q, Vec xi) = 0;
  /// q = the configuration at xi, which solves the stage. Unknowns that are not part of q are kept for the next guess.
  virtual void leave(Vec xi, Vec q) { check(VecCopy(xi, q)); }
  /// For a stage that was not solved: resets unknowns that are not part of q to those of the last solution.
  virtual void give_up() {}

  /// Before a stage is solved: freezes the coefficients of terms that refreeze at q, as the following calls see them.
  /// After `enter`, until then, these coefficients follow q, and there is no potential.
  virtual void freeze(Vec /*q*/) {}
  /// The same when there is a solution; false, and nothing is done, if coefficients may stay as they are: there are
  /// none that refreeze, and those frozen at the step's start do not exceed what they may do at q (EnergyTerm::bound).
  /// Once they do they refreeze, too, until the next call of `freeze`. A stage is solved when its solution, and the q
  /// of the last call, are one.
  virtual bool refreeze(Vec /*q*/) { return false; }

  /// Brings what the stage gives, besides prescribed entries of q, to a part of its way from the accepted state (0) to
  /// the end of the stage (1), where it stands after `enter`.
  virtual void lead(double /*part*/) {}
  /// q = the accepted state, each body that nothing holds moved rigidly to where its inertia leads it; false where
  /// there is no such body, and q is as it was.
  virtual bool move_rigidly(Vec /*q*/) { return false; }

  /// Which nodes go with an obstacle that has moved.
  enum class Carried {
    near,   ///< those near it, the others the less the farther they are
    bodies  ///< all nodes, by the mean way of those nearest
  };
  /// q = the accepted state, nodes moved as the obstacles have that would else have moved onto them; false where none
  /// has moved near a node.
  virtual bool carry_along(Carried /*which*/, Vec /*q*/) { return false; }

  /// Phi(q) of the terms that are potentials [J], but for a constant of the stage; +inf where a barrier is crossed or a
  /// number is not finite.
  virtual double value(Vec q) = 0;
  /// r(q) [N], zero on prescribed entries; the gradient of `value` if is_potential().
  virtual void gradient(Vec q, Vec r) = 0;
  /// A zero matrix for the Hessian, with a near-null space where there is one.
  virtual Handle<Mat> make_hessian() const = 0;
  /// A coarse space of the unknowns for multigrid; nullopt where there is none.
  virtual std::optional<Coarsening> make_coarsening() const { return std::nullopt; }
  /// Rotations of the nodes whose displacements are unknowns, for corotated preconditioners; nullptr if the unknowns
  /// are of another kind, or the stiffness is constant (linear elasticity).
  virtual std::unique_ptr<NodalRotations> make_rotations() const { return nullptr; }
  /// The displacements of all nodes at the unknowns q, until the next call. What belongs to them comes first among the
  /// unknowns of each rank.
  virtual Vec displacements(Vec q) { return q; }
  /// The unknowns from which the present ones were reached along a straight line; nullptr: they were not. Hessians may
  /// take stresses as that line extrapolates them, which makes Newton's method converge as if they were unknowns too.
  virtual void extrapolate_from(Vec /*q*/) {}
  /// K = dr/dq [N/m] without the parts of rank one, or an approximation; rows and columns of prescribed entries are
  /// zero but for the diagonal.
  virtual void hessian(Vec q, Mat K, Projection projection) = 0;
  /// The number of rank-one terms of the Hessian in addition to K.
  virtual std::size_t num_rank_one() const { return 0; }
  /// The rank-one terms at q; `parts` has num_rank_one() of them, with vectors of make_vector().
  virtual void rank_one_parts(Vec /*q*/, std::vector<RankOne>& /*parts*/) {}
  /// The largest alpha for which q + alpha d stays clear of all barriers.
  virtual double max_step(Vec q, Vec d) = 0;
  /// Likewise for the barriers that must not be jumped over (TermDeclaration::is_wall).
  virtual double max_way(Vec /*q*/, Vec /*d*/) { return std::numeric_limits<double>::infinity(); }
  /// Sum over the terms of the norms of their forces, those on prescribed entries included [N]: the size of the forces
  /// that must balance.
  virtual double force_scale(Vec q) = 0;
  /// Norm of the forces that would stop the bodies within the stage, M v0 / dt; 0 without inertia [N].
  virtual double inertia_scale() { return 0.0; }
  /// Size of the rounding errors in r at q [N].
  virtual double rounding_floor(Vec q) const = 0;

  /// The size of the diagonal of K in D: what a unit of each unknown weighs.
  virtual void size_of_diagonal(Mat K, Vec D) const { check(MatGetDiagonal(K, D)); }
  /// Properties of K at a stable solution.
  virtual PetscInt num_negative_pivots() const { return 0; }

  /// Whether a stage asks for an equilibrium, which need not be stable: there is no inertia.
  virtual bool is_static() const { return false; }
  /// Names of the terms without a potential, each once; empty if r is the gradient of `value`.
  virtual std::vector<std::string> non_potentials() const = 0;
  bool is_potential() const { return non_potentials().empty(); }
  virtual Symmetry symmetry() const = 0;

  /// One flag per owned entry (at least).
  virtual const std::vector<char>& prescribed() const = 0;
  virtual PetscInt num_unknowns() const = 0;
  virtual MPI_Comm comm() const = 0;
  /// A zero vector of the unknowns.
  virtual Handle<Vec> make_vector() const = 0;
};

}  // namespace pliant
