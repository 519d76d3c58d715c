/// Projection of the velocities of rigid parts, by their own mass and that of the soft bodies around them.
#pragma once

#include "energy/constraint/reduced_mass.hpp"
#include "energy/rigid/joint_equation.hpp"

#include <array>
#include <eigen3/Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

class RigidPart;

/// The projection of VelocityProjection where v' fulfils the constraints except at rigid parts. Velocities of a part
/// are affine in stages, v(X) = c_0 + sum_k c_k (X - centre)_k: twelve numbers c. The soft nodes s around parts follow
/// a change c of these velocities by -Y c, Y = M_ss^-1 M_sd Phi, Phi the affine motions of the parts' nodes d: the
/// fields Y do not change and are found once. What remains of the projection is
///
///   J^T S (c - c') = 0,   S = Phi^T (M_dd - M_ds M_ss^-1 M_sd) Phi,   c - c_c = J w,
///
/// with the motions J of the parts by the unknowns of the constraints (rigid parts, mechanisms), which are few.
class PartVelocityProjection {
 public:
  /// Nothing if there are many parts that soft cells touch: the fields would take too much memory. The references in
  /// `bodies` outlive the object. Collective.
  static std::unique_ptr<PartVelocityProjection> make(const ConstrainedMass& bodies);

  /// Replaces v, which fulfils the constraints at q, by the projection of v', which it meets except at rigid parts.
  /// Collective.
  void operator()(Vec q, Vec wanted, Vec v);

 private:
  static constexpr std::size_t num_affine = 4, num_motions = 3 * num_affine;
  using Motion = Eigen::Matrix<double, num_motions, 1>;  ///< c_0, c_1, .. one after another
  using Mass = Eigen::Matrix<double, num_affine, num_affine>;
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;
  static constexpr std::size_t alone = static_cast<std::size_t>(-1);

  struct Part {
    const RigidPart* part = nullptr;
    std::size_t dependent = 0, number = 0;  // of the DependentNodes, and among its parts
    Vector3<double> centre{};
    Mass mass = Mass::Zero();   // of its own nodes, the same for each component [kg, kg m, kg m^2]
    std::size_t place = alone;  // among the parts that others touch
  };
  /// A column of Y: owned entries that are not negligible.
  struct Field {
    std::vector<PetscInt> entries;
    std::vector<double> values;
  };
  struct Touched;  // what the constructor keeps of a part that others touch

  explicit PartVelocityProjection(const ConstrainedMass& bodies);
  void find_parts();
  void measure(const ConstrainedMass& bodies);
  void add_fields(ReducedMass& mass, Touched& touched);
  void subtract_soft_mass(const std::vector<Touched>& touched);
  /// The affine motion k of a part's nodes, of all components or of one; v is zero elsewhere.
  void put_motion(const Part& part, std::size_t k, Vec v) const;
  /// Adds the projected change of the velocities of some constraints to `changes`, of all parts. `dependents`: those
  /// with parts that others touch, together, or one of those without.
  void solve(std::span<const std::size_t> dependents, const std::vector<Motion>& missing,
             std::vector<Motion>& changes) const;
  void put(const std::vector<Motion>& missing, const std::vector<Motion>& changes, Vec v) const;

  const NodeLayout& layout_;
  ConstraintMap& map_;
  std::vector<Part> parts_;
  std::vector<std::vector<std::size_t>> groups_;  // constraints that are projected together
  std::size_t num_touched_ = 0;
  Matrix touched_mass_;        // S of the parts that others touch
  std::vector<Field> fields_;  // num_motions per such part
  Handle<Vec> difference_;
};

}  // namespace pliant
