/// The equations of all joints of a mechanism, and their derivatives.
#pragma once

#include "energy/given_motion.hpp"
#include "energy/rigid/joint_derivative.hpp"
#include "energy/rigid/joint_equation.hpp"

#include <eigen3/Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// The force and the torque of a joint on its second body.
struct JointReaction {
  Vector3<double> force{};   ///< [N]
  Vector3<double> torque{};  ///< about the joint's point [N m]
};

/// a x + y.
BodyMotion<double> sum_of(double a, const BodyMotion<double>& x, const BodyMotion<double>& y);
/// y += a x.
void add(double a, const BodyMotion<double>& x, BodyMotion<double>& y);

/// g_j(motions, t) = 0 for each equation j of the joints between some bodies; the unknowns of body p have the numbers
/// first[p] .. first[p + 1] - 1. Equations are scaled such that their derivatives at the reference configuration have
/// length 1: values are lengths [m].
class JointSystem {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;
  using Given = std::vector<TimeSeries<double>>;  ///< of the formula of each equation, 0 where it has none
  enum class Along { columns, test_columns };

  JointSystem(std::vector<JointEquation> equations, std::vector<std::size_t> first);

  bool empty() const { return equations_.empty(); }
  /// JointEquation::joint.
  std::size_t joint_of(Eigen::Index equation) const { return equations_[static_cast<std::size_t>(equation)].joint; }
  /// Whether an equation is one of lengths, and not of directions, which are numbers.
  bool is_length(Eigen::Index equation) const;
  /// What its members in `configuration` and `rates` were multiplied by (scale_rows).
  double scale(Eigen::Index equation) const { return scales_[static_cast<std::size_t>(equation)]; }
  /// Whether a formula of time moves a joint.
  bool is_driven() const;
  /// One more than the largest number of a joint.
  std::size_t num_joints() const;
  /// The first unknown of each body, and their number.
  std::span<const std::size_t> first() const { return first_; }
  /// Scales the equations such that the rows of G, their derivatives, have length 1; scales G too.
  void scale_rows(JointDerivative& G);

  /// What is given, one-sided in time; rates are times `unit`, accelerations times its square. `time_scale`: formulas
  /// are smooth over this time on that side. `factor` multiplies them.
  Given given(double time, double time_scale, double unit, double factor, Side side) const;
  /// g and its derivative by the unknowns.
  void configuration(std::span<const PartMotion> parts, Along along, const Given& given, Vector& g,
                     JointDerivative& G) const;
  /// dt^2 d2g/dt2 of a stage, and its derivative by the unknowns, with x' = (x - x0) / dt, x'' = (x - x0 - dt v0) /
  /// dt^2; `advance`: dt v0; rates of what is given are times dt.
  void acceleration(std::span<const PartMotion> parts, std::span<const BodyMotion<double>> start,
                    std::span<const BodyMotion<double>> advance, const Given& given, Vector& h,
                    JointDerivative& G) const;
  /// Whether solutions are those that are meant: a turn is known up to half a turn by its equation, a distance up to
  /// its sign.
  bool is_on_branch(std::span<const PartMotion> parts, const Given& given) const;
  /// dg/dt.
  Vector rates(std::span<const BodyMotion<double>> values, std::span<const BodyMotion<double>> rates,
               const Given& given) const;
  /// sum_j lambda_j d2g_j / (virtual k) (actual l). `bends`: for each body of n unknowns, the derivative of its virtual
  /// motion k by its unknown l, at k n + l.
  Matrix curvature(std::span<const PartMotion> parts, std::span<const std::vector<BodyMotion<double>>> bends,
                   const Given& given, const Vector& lambda) const;
  /// The joints of which equations repeat what other equations say, or contradict it, and the number of equations that
  /// are too many. G: the derivatives.
  struct Dependent {
    std::vector<std::size_t> joints;
    int number = 0;
  };
  Dependent dependent_joints(const JointDerivative& G) const;
  /// The reaction of each joint, from the forces lambda of the equations. `points`: of the joints on their second
  /// bodies, in the reference configuration [m].
  std::vector<JointReaction> reactions(std::span<const PartMotion> parts, const Given& given, const Vector& lambda,
                                       std::span<const Vector3<double>> points) const;

 private:
  Eigen::Index num_equations() const { return static_cast<Eigen::Index>(equations_.size()); }
  Eigen::Index num_unknowns() const { return static_cast<Eigen::Index>(first_.back()); }
  /// The derivative of an equation by the unknowns of its bodies.
  void put_row(std::size_t row, const JointEquation::Forces& forces, std::span<const PartMotion> parts, Along along,
               JointDerivative& G) const;

  std::vector<JointEquation> equations_;
  std::vector<double> scales_;
  std::vector<std::size_t> first_;
  std::shared_ptr<const JointPattern> pattern_;
};

}  // namespace pliant
