/// The configuration as a function of the unknowns (degrees of freedom) that constraints leave.
#pragma once

#include "energy/constraint/linear_constraint.hpp"
#include "energy/rigid/rigid_patch.hpp"
#include "fem/layout.hpp"
#include "time/stage.hpp"

#include <array>
#include <functional>
#include <map>
#include <vector>

namespace pliant {

/// How a vector is changed so that it fulfils the constraints.
enum class Mending {
  nearest,   ///< the least change of all entries: for methods that act on configurations
  of_slaves  ///< slaves follow their masters: for methods that act on the unknowns alone
};

/// q = T(y) = C y + g(t), where y has the layout of q: rows of slaves hold their masters' coefficients, all other rows
/// are those of the identity; the entries of slaves in y have no meaning. Masters may be on other ranks. Nodes of rigid
/// patches (RBE2) that rotate freely are placed by the patch's unknowns: there T is nonlinear, and its Jacobian J
/// depends on y. Forces f on q balance if W^T f = 0; the columns of W are the virtual displacements that the
/// constraints allow, equal to J unless a patch is rigid in its accelerations. All methods are collective unless they
/// say otherwise.
class ConstraintMap {
 public:
  /// `slaves`: those of all ranks, none of a patch. `given`: the displacements that their given terms refer to.
  ConstraintMap(const NodeLayout& layout, std::span<const Slave> slaves, std::vector<GivenDisplacement> given,
                std::vector<RigidPatch> patches = {});

  /// How patches are kept rigid; to be called before the map is used.
  void set_rigidity(Rigidity rigidity);
  /// Begins a stage, to which all following calls refer; q: a guess of its end.
  void begin_stage(const StagePoint& stage, Vec q);
  /// Sets g to its value at a fraction between the accepted state (0) and the end of the stage (1), which is where
  /// begin_stage leaves it.
  void set_prescribed_fraction(double fraction);
  /// q = T(y).
  void expand(Vec y, Vec q) const;
  /// Evaluates `jacobian` and `test_matrix` at y.
  void linearize(Vec y);
  /// Evaluates `jacobian` at the end of a step, whose configuration is q: its columns are the velocities that the
  /// constraints allow. Valid until the next begin_stage.
  void linearize_at(Vec q);
  /// Reduces v to the free motion of patches: removes the prescribed part from the entries of their nodes.
  void keep_free_patches(Vec v) const;
  /// J, with places for the diagonal entries of slaves, which are zero.
  Mat jacobian() const { return J_.get(); }
  /// W, likewise.
  Mat test_matrix() const { return W_.get(); }
  /// K += sum_i f_i dW_i/dy; `f`: forces on q. `place`: the index of an entry of y in K.
  void add_curvature(Vec y, Vec f, Mat K, const std::function<PetscInt(PetscInt)>& place) const;
  /// Rounding errors of ties: x = in the entry of each slave the sum of |C_sm q_m| over its masters, which bounds its
  /// error by cancellation, times the fraction of an error of its force that reaches them by C^T; 0 in all other
  /// entries.
  void weigh_slaves(Vec q, Vec x) const;
  /// A new vector with the layout of q and y. Not collective.
  Vec vector() const { return offset_.get(); }

  /// Whether T is linear: then y = q will do. Not collective.
  bool is_linear() const { return patches_.empty(); }
  /// Whether W = J. Not collective.
  bool is_symmetric() const { return W_.get() == J_.get(); }
  /// y = the unknowns whose configuration is close to q, the closest one if patches are rigid there.
  void restrict(Vec q, Vec y) const;
  /// w = the rates of the unknowns at rest whose velocities are closest to v.
  void restrict_rates(Vec v, Vec w) const;

  /// One flag per owned entry: whether it is a slave. Not collective.
  const std::vector<char>& is_slave() const { return is_slave_; }
  /// One flag per owned entry: whether it is a slave or a master, where constraints do work. Not collective.
  const std::vector<char>& is_tied() const { return is_tied_; }

  /// `before`, then the motion that the constraints prescribe: where g depends on time, its own velocity and
  /// acceleration hold exactly, as for prescribed displacements (energy/constraint/prescribed.hpp). The remaining error
  /// of a method's formulas is corrected by the least change of all entries: the formulas then act on the coordinates
  /// along the constraints, which keeps their order, and the choice of slaves makes no difference. At the end of a step
  /// patches are rigid again, and so are their velocities. With `Mending::of_slaves`, where T is linear, only slaves
  /// are changed. Refers to this object. Not collective.
  PrescribedMotion motion(PrescribedMotion before, Mending mending = Mending::nearest) const;

  /// Reactions of the prescribed displacements, per source and component: the work of the constraints per unit of
  /// prescribed displacement [N]. `reaction`: the gradient of the potential. This rank's part, without patches. Not
  /// collective.
  std::vector<std::array<double, 3>> multipliers(Vec reaction) const;

 private:
  void put_columns(Mat matrix, const RigidPatch& patch, PetscInt node, const RigidPatch::Columns& columns) const;
  struct OwnedSlave {
    PetscInt local_entry;
    std::vector<GivenTerm> given;
  };
  /// Coefficients by column, per owned entry.
  using Rows = std::vector<std::map<PetscInt, double>>;
  Handle<Mat> make_matrix(const Rows& rows) const;
  Handle<Mat> make_jacobian(Rows rows);
  /// g per slave.
  std::vector<Kinematics> offsets(double time, double time_scale, double factor, Side side = Side::before) const;
  /// x = C x + offset(slave) in the entries of slaves, by the least change of all entries: it does not depend on which
  /// entries are slaves.
  template <class Offset>
  void put_nearest(Vec x, Offset offset) const;
  /// x = C x + offset(slave) in the entries of slaves, by these alone.
  template <class Offset>
  void follow(Vec x, Offset offset) const;
  /// y = G x for the constraints G x = 0, that is x_s - (C x)_s, in the entries of slaves; else 0.
  void constrain(Vec x, Vec y) const;
  /// x += G^T m, m in the entries of slaves, and zero elsewhere.
  void add_constraint_forces(Vec m, Vec x) const;

  MPI_Comm comm_;
  PetscInt first_entry_;
  std::vector<GivenDisplacement> given_;
  std::vector<OwnedSlave> slaves_;
  std::vector<RigidPatch> patches_;
  std::vector<char> is_slave_, is_tied_;
  Handle<Mat> C_, J_, W_;                           // the same if T is linear
  Handle<Vec> offset_, start_offset_, end_offset_;  // g: prescribed values; at the accepted state; at the stage's time
  Handle<Mat> sizes_;                               // |C|
  Handle<Vec> work_;
  // put_nearest: the violation, the forces that correct it, the search direction and its image.
  Handle<Vec> missing_, forces_, direction_, image_;
  Handle<Vec> inverse_diagonal_;  // of G G^T; 0 except for slaves
};

}  // namespace pliant
