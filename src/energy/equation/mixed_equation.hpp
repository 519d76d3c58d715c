/// The equation of a stage with pressures: displacements and pressures as unknowns of one saddle point.
///
/// Unknowns x = (q, y): on each rank the owned displacements, then the owned pressures p = s y, where s [Pa/m] is the
/// shear modulus over the size of a cell. This gives y and its equations the units and the size of q and of its forces.
/// With Pi the stage's potential (energy/volume/mixed.hpp)
///
///     r = (dPi/dq, s dPi/dp),   matrix [K, s B; s B^T, -s^2 C],   K = d2Pi/dq2
///
/// The matrix of a stable state has exactly one negative eigenvalue for each pressure.
#pragma once

#include "energy/equation/incremental_potential.hpp"
#include "energy/equation/pressure_projection.hpp"
#include "energy/volume/mixed.hpp"
#include "petsc/archive.hpp"

#include <optional>
#include <span>
#include <vector>

namespace pliant {

class MixedEquation final : public StageEquation {
 public:
  /// `potential` is the sum of all terms; `mixed` are those of them with pressures, numbered by `pressures`. The
  /// references outlive the object. `rigid_parts`: for each local node its rigid part, 0 if none; may be empty.
  /// Collective.
  MixedEquation(IncrementalPotential& potential, const NodeLayout& layout, std::vector<const MixedTerm*> mixed,
                PressureField& pressures, std::span<const int> rigid_parts = {});

  const PressureLayout& pressure_layout() const { return pressures_.layout(); }
  /// The present pressures, with ghosts [Pa].
  Vec pressures() const { return pressures_.values(); }
  /// Whether displacements that are free feel every pressure. Incompressible bodies whose whole surface is held do not
  /// feel a pressure that is the same everywhere. Collective.
  bool determines_pressures() const;
  /// Sets the pressures from which the next solve starts. Collective.
  void keep(Archive& archive);
  /// Sets the pressures to those that belong to the displacements at the instant, dPi/dp = 0: for states that are not
  /// the end of a stage. Every body must be compressible. Collective.
  void settle(Vec q, const Instant& at);

  /// The guess of the pressures is their last solution.
  StagePoint enter(const StagePoint& stage, Vec q, Vec x) override;
  void leave(Vec x, Vec q) override;
  void give_up() override;
  void forget() override { potential_.forget(); }
  void freeze(Vec x) override;
  bool refreeze(Vec x) override;
  bool exceeds_bound() const override { return potential_.exceeds_bound(); }
  void exceed_bound() override { potential_.exceed_bound(); }
  void drag(Vec x, Vec at, Vec f) override;
  double value(Vec x) override;
  void gradient(Vec x, Vec r) override;
  Vec displacements(Vec x) override;
  Handle<Mat> make_hessian() const override;
  void hessian(Vec x, Mat A, Projection projection) override;
  std::size_t num_rank_one() const override { return potential_.num_rank_one(); }
  void rank_one_parts(Vec x, std::vector<RankOne>& parts) override;
  bool is_static() const override { return potential_.is_static(); }
  bool move_rigidly(Vec x) override;
  bool follow_obstacles(Followers which, Vec x) override;
  bool follow_prescribed_nodes(Vec x) override;
  double max_step(Vec x, Vec d) override;
  bool has_walls() const override { return potential_.has_walls(); }
  double max_step_to_wall(Vec x, Vec d, Walls which) override;
  double force_scale(Vec x) override;
  double inertia_scale() override { return potential_.inertia_scale(); }
  double rounding_floor(Vec x) const override;
  void size_of_diagonal(Mat A, Vec D) const override;
  std::vector<std::string> non_potentials() const override;
  Symmetry symmetry() const override;
  PetscInt num_negative_pivots() const override { return pressures_.layout().num_global; }
  const std::vector<char>& prescribed() const override { return prescribed_; }
  PetscInt num_unknowns() const override { return potential_.num_unknowns() + pressures_.layout().num_global; }
  MPI_Comm comm() const override { return layout_.comm; }
  Handle<Vec> make_vector() const override;

 private:
  /// Global indices in x of a local displacement and of a local pressure.
  PetscInt global_displacement(PetscInt entry) const;
  PetscInt global_pressure(PetscInt pressure) const;
  bool is_prescribed(PetscInt node, int component) const { return potential_.prescribed()[3 * node + component] != 0; }
  /// Finds pressures without influence: those of incompressible cells whose motion is prescribed or rigid. They are set
  /// to 0.
  void find_idle_pressures(std::span<const int> rigid_parts);
  /// Calls `visit(row, column, value)` for the entries that couple pressures, always in the same order.
  template <class Visit>
  void for_each_coupling(std::span<const double> q, const Visit& visit) const;
  /// Copies x to q and to the field.
  void set(Vec x);
  void join(Vec q, Vec x) const;
  /// Joins the displacements that have just been found, if they were.
  bool join_if(bool is_found, Vec x) const {
    if (is_found) join(q_.get(), x);
    return is_found;
  }
  void take_displacement(Vec x, Vec q) const;
  /// r = dPi/dp, owned and complete; q has its ghosts.
  void pressure_gradient(const Instant& at, std::span<const double> q, Vec r) const;
  void attach_parts(Mat A) const;

  IncrementalPotential& potential_;
  const NodeLayout& layout_;
  std::vector<const MixedTerm*> mixed_;
  PressureField& pressures_;
  PetscInt num_q_, num_p_;                             // owned
  std::vector<PetscInt> first_node_, first_pressure_;  // of each rank, and their totals
  double scale_ = 1.0;                                 // s [Pa/m]
  std::vector<char> prescribed_;
  std::vector<char> is_idle_;              // per local pressure
  std::vector<double> pressure_diagonal_;  // s^2 int N dX / mu of owned pressures: their size in the matrix
  PresentPattern present_pattern_;
  PetscObjectId pattern_of_K_ = 0;
  Handle<Mat> K_;
  std::optional<PressureProjection> projection_;  // made when it is needed
  Instant instant_;                               // of the stage
  std::vector<RankOne> rank_one_;                 // of the potential
  Handle<Vec> q_, r_, d_, work_, last_pressures_;
  Handle<Vec> q0_, v0_, accepted_;  // of the stage, in x
  std::vector<double> values_;      // of the matrix's entries, in coordinate (COO) order
};

}  // namespace pliant
