/// The configuration as a function of the unknowns (degrees of freedom) that constraints leave.
#pragma once

#include "energy/constraint/dependent_nodes.hpp"
#include "energy/constraint/linear_ties.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pliant {

/// q = T(y), where y has the layout of q:
///
///   in the entries of slaves   q_s = sum_m C_sm y_m + g_s(t)   (LinearTies),
///   at dependent nodes         q_a = Q_a(x), x the entries of y that are their hosts   (DependentNodes),
///   in all other entries       q = y.
///
/// Entries of y at slaves, and at dependent nodes unless they are hosts, have no meaning. With dependent nodes T is
/// nonlinear, and its Jacobian J depends on y. Forces f on q balance if W^T f = 0; the columns of W are the virtual
/// displacements that the constraints allow, equal to J unless accelerations are kept rigid. Maps are collective, in
/// all methods that do not say otherwise.
class ConstraintMap {
 public:
  /// `slaves`: those of all ranks, with neither slave nor master among the dependent nodes. `given`: the displacements
  /// that their given terms refer to. No two of `dependents` share a node.
  ConstraintMap(const NodeLayout& layout, std::span<const Slave> slaves, std::vector<GivenDisplacement> given,
                std::vector<std::unique_ptr<DependentNodes>> dependents = {});

  /// How dependent nodes are kept rigid; to be called before the map is used.
  void set_rigidity(Rigidity rigidity);
  /// Begins a stage, to which all following calls refer; q: a guess of its end.
  void begin_stage(const StagePoint& stage, Vec q);
  /// Sets what is prescribed to a fraction between the accepted state (0) and the end of the stage (1), where it is
  /// after `begin_stage`.
  void set_prescribed_fraction(double fraction);
  /// q = T(y).
  void expand(Vec y, Vec q) const;
  /// Evaluates `jacobian` and `test_matrix` at y.
  void linearize(Vec y);
  /// Evaluates `jacobian` at the end of a step, whose configuration is q: its columns are the velocities that the
  /// constraints allow. Valid until the next begin_stage.
  void linearize_at(Vec q);
  /// DependentNodes::begin_end_of_step, of all.
  void begin_end_of_step(Vec q);
  /// Reduces v to the free motion of dependent nodes: removes what is prescribed there, and all other entries.
  void keep_free_motion_of_dependents(Vec v) const;
  /// J, with places for the diagonal entries of slaves, which are zero.
  Mat jacobian() const { return J_.get(); }
  /// W, likewise.
  Mat test_matrix() const { return W_.get(); }
  /// K += sum_i f_i dW_i/dy; `f`: forces on q. `place`: the index of an entry of y in K.
  void add_curvature(Vec y, Vec f, Mat K, const std::function<PetscInt(PetscInt)>& place) const;
  /// DependentNodes::is_driven, of any. Not collective.
  bool is_driven() const;
  /// DependentNodes::refreezes, of any. Not collective.
  bool refreezes() const;
  /// DependentNodes::refreeze, of all, at y; r: a gradient in q.
  void refreeze(Vec y, Vec r);
  /// LinearTies::weigh_slaves.
  void weigh_slaves(Vec q, Vec x) const { ties_.weigh_slaves(q, x); }
  /// A vector with the layout of q and y.
  Handle<Vec> make_vector() const;

  const std::vector<std::unique_ptr<DependentNodes>>& dependents() const { return dependents_; }
  /// Whether entries depend linearly on others. Not collective.
  bool has_ties() const { return has_ties_; }
  /// Whether T is linear: then y = q will do. Not collective.
  bool is_linear() const { return dependents_.empty(); }
  /// Whether W = J. Not collective.
  bool is_symmetric() const { return W_.get() == J_.get(); }
  /// The number of unknowns whose rows of W are not those of J. Not collective.
  PetscInt64 num_unsymmetric() const;
  /// The unknowns that `num_unsymmetric` counts, as entries of y, ascending. Not collective.
  std::vector<PetscInt> unsymmetric_unknowns() const;
  /// The constraints for which W is not J, each once, as plurals. Not collective.
  std::vector<std::string> non_potentials() const;
  /// DependentNodes::rotation, the largest of all. Not collective, but the same on every rank.
  double rotation(Vec y) const;
  double rotation_by(Vec step, Vec y) const;
  /// y = the unknowns whose configuration is close to q, the closest one if q fulfils the constraints.
  void restrict(Vec q, Vec y) const;
  /// w = the rates of the unknowns at rest whose velocities are closest to v.
  void restrict_rates(Vec v, Vec w) const;

  /// v = 0 at dependent nodes. Not collective.
  void clear_dependents(Vec v) const;

  /// One flag per owned entry: whether the entry of y has no meaning. Not collective.
  const std::vector<char>& is_slave() const { return is_slave_; }
  /// One flag per owned entry: whether it is of a dependent node whose constraint does no work. Not collective.
  std::vector<char> is_ideal() const;
  /// One flag per owned entry: whether constraints do work there, as on a slave or a master. Not collective.
  const std::vector<char>& is_tied() const { return is_tied_; }

  /// `before`, then the motion that the constraints prescribe (the methods of these names of LinearTies and
  /// DependentNodes). With `Correction::of_slaves` T is linear. Refers to this object. Not collective.
  PrescribedMotion motion(PrescribedMotion before, Correction correction = Correction::nearest) const;

  /// LinearTies::multipliers. Not collective.
  std::vector<std::array<double, 3>> multipliers(Vec reaction) const { return ties_.multipliers(reaction); }
  /// LinearTies::for_each_given. Not collective.
  template <class Visit>
  void for_each_given(Vec reaction, const Visit& visit) const {
    ties_.for_each_given(reaction, visit);
  }

 private:
  using PutColumns = void (DependentNodes::*)(std::span<const double>, PetscInt, std::span<Vector3<double>>) const;
  void find_places();
  /// Sets the rows of the dependent nodes of this number.
  void put_rows(Mat matrix, std::size_t dependent, std::span<const double> unknowns, PutColumns put) const;
  /// The unknowns from their hosts in y, on every rank. Collective.
  std::vector<double> unknowns_of(const DependentNodes& dependent, Vec y) const;
  /// Writes the unknowns to their hosts in y.
  void put_unknowns(const DependentNodes& dependent, std::span<const double> unknowns, Vec y) const;
  bool owns(PetscInt entry) const { return entry >= first_entry_ && entry < first_entry_ + num_owned_; }

  MPI_Comm comm_;
  PetscInt first_entry_, num_owned_;
  bool has_ties_;
  LinearTies ties_;
  std::vector<std::unique_ptr<DependentNodes>> dependents_;
  std::vector<char> is_slave_, is_tied_;
  Handle<Mat> J_, W_;                               // the same where W = J
  std::vector<std::vector<PetscInt>> places_;       // per dependent: entries of its rows, in order, for its hosts
  std::vector<std::vector<double>> linearized_at_;  // unknowns of the dependents in this stage; empty: nowhere yet
};

}  // namespace pliant
