/// Small vibrations of a model about a state.
#pragma once

#include "model/model.hpp"
#include "solver/eigenpairs.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// The state about which a model vibrates.
struct BaseState {
  Vec q = nullptr;           ///< displacements of the nodes, with ghosts [m]
  Vec z = nullptr;           ///< internal variables; nullptr if there are none
  double time = 0.0;         ///< at which loads are evaluated [s]
  double load_factor = 1.0;  ///< StagePoint::load_factor
};

/// What a body that nothing holds keeps: linear momentum over the square root of the mass, then angular momentum about
/// the centre of mass over that of the moment of inertia, each along x, y, z.
inline constexpr int num_momenta = 6;

/// Throws InputError where no body has a mass. Collective.
void require_mass(const Config& config, const Model& model);

/// The eigenvalue problem of M q'' + K q = 0 in the unknowns that constraints leave free: K is the exact Hessian of the
/// static potential at the state, M the mass matrix, both reduced by the tangent of the constraints. The rank-one terms
/// of K (cavities) are unknowns of their own in a bordered matrix, as pressures of mixed bodies are. All methods are
/// collective.
class Vibration {
 public:
  /// `config` is static, and that of the model, which has a mass and outlives the object. Throws InputError where
  /// forces have no potential, because modes need a symmetric K, and where constraints hold everything.
  Vibration(const Config& config, Model& model, const BaseState& about);

  EigenProblem problem() const { return {K_.get(), M_.get(), num_negative_}; }
  /// Norm of the unbalanced forces as a fraction of all forces; 0 at an equilibrium.
  double imbalance() const { return imbalance_; }
  double mass() const { return mass_; }  ///< of all bodies [kg]

  /// u = the displacements of the nodes, with ghosts, in an eigenvector x.
  void expand(Vec x, Vec u) const;
  /// The momenta of nodes with the velocities u.
  std::array<double, num_momenta> momenta(Vec u) const;
  /// u . C u, with the viscosity C of bodies and rods at the state [kg/s per square of u's unit].
  double dissipation(Vec u) const;
  /// Kinds of viscosity that `dissipation` leaves out: those that relax.
  const std::vector<std::string>& relaxing() const { return relaxing_; }
  bool is_damped() const { return damping_ != nullptr; }

 private:
  StagePoint stage(const BaseState& about) const;
  void measure_mass(Vec q);
  void find_free(const StageEquation& equation);
  void set_matrices(const BaseState& about);
  /// J^T M J in the unknowns that constraints leave, J their tangent.
  Handle<Mat> reduced_mass(const BaseState& about) const;
  /// Adds them to K.
  void add_rank_one(const std::vector<RankOne>& parts);
  Handle<Vec> make_free_vector() const;
  void set_damping(const Config& config, const BaseState& about);
  Handle<Mat> part_of_free(Mat whole) const;
  /// K with a further unknown for each rank-one term.
  Handle<Mat> bordered(Mat K, const std::vector<Handle<Vec>>& columns, double scale) const;

  Model& model_;
  std::vector<PetscInt> free_;  // owned unknowns, numbers on this rank
  Handle<IS> free_set_;
  Handle<Mat> K_, M_;
  PetscInt num_negative_ = 0;
  bool has_motion_ = false;  // of what has a mass
  double imbalance_ = 0.0, mass_ = 0.0;
  std::array<double, 3> centre_{}, moments_{};  // of mass [m]; of inertia [kg m^2]
  Handle<Vec> q_, y_;
  std::vector<std::unique_ptr<EnergyTerm>> damping_terms_;
  std::unique_ptr<IncrementalPotential> damping_;
  Handle<Mat> C_;
  Handle<Vec> zero_;  // velocity
  std::vector<std::string> relaxing_;
};

}  // namespace pliant
