#include "energy/rigid/joint_bearing.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/LU>
#include <eigen3/Eigen/QR>

namespace pliant {
namespace {

const PartMotion of_ground{};

const PartMotion& part_of(int body, std::span<const PartMotion> parts) {
  return body < 0 ? of_ground : parts[static_cast<std::size_t>(body)];
}

/// x + h dx, to the first order in h.
BodyMotion<Dual<double>> along(const BodyMotion<double>& x, const BodyMotion<double>& dx) {
  BodyMotion<Dual<double>> result{x.centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) result.translation[i] = {x.translation[i], dx.translation[i]};
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = {x.gradient.a[i], dx.gradient.a[i]};
  return result;
}

/// Unit rows of which less than this is left beyond others depend on these: the projection would magnify what is out of
/// equilibrium by the inverse.
constexpr double dependent = 1e-4;

/// Whether the rows of D are independent of those of G, and of one another.
bool are_independent(const JointSystem::Matrix& G, const JointSystem::Matrix& D) {
  JointSystem::Matrix rows(G.rows() + D.rows(), G.cols());
  rows << G, D;
  auto qr = JointSystem::Matrix(rows.rowwise().normalized().transpose()).colPivHouseholderQr();
  qr.setThreshold(dependent);
  return qr.rank() == rows.rows();
}

JointSystem::Vector forces_of_joints(const JointSystem::Matrix& G, const JointSystem::Matrix& D,
                                     const JointSystem::Vector& phi) {
  if (!are_independent(G, D)) return JointSystem::Matrix(G * G.transpose()).partialPivLu().solve(G * phi);
  const auto square = JointSystem::Matrix(D * D.transpose()).partialPivLu();
  const JointSystem::Matrix projected = G - G * D.transpose() * square.solve(D);
  return JointSystem::Matrix(projected * G.transpose()).partialPivLu().solve(projected * phi);
}

}  // namespace

double largest_friction(const JointBearing& bearing, const JointReaction& reaction, const Vector3<double>& n) {
  const double along_axis = dot(reaction.force, n), about_axis = dot(reaction.torque, n);
  const Vector3<double> across = reaction.force - along_axis * n;
  const Vector3<double> couple =
      bearing.length ? (1.0 / *bearing.length) * cross(n, reaction.torque) : Vector3<double>{};
  const double load = norm(0.5 * across + couple) + norm(0.5 * across - couple);
  if (std::holds_alternative<JointAngle>(bearing.coordinate)) {
    return bearing.friction * bearing.radius.value_or(0.0) * (load + std::abs(along_axis));
  }
  return bearing.friction * (load + (bearing.radius ? std::abs(about_axis) / *bearing.radius : 0.0));
}

std::shared_ptr<const double> JointBearings::add(const JointBearing& bearing) {
  bearings_.push_back(bearing);
  return largest_.emplace_back(std::make_shared<double>(0.0));
}

void JointBearings::release() {
  for (const auto& largest : largest_) *largest = 0.0;
}

JointSystem::Matrix JointBearings::slopes(std::span<const PartMotion> parts, std::span<const std::size_t> first) const {
  JointSystem::Matrix result =
      JointSystem::Matrix::Zero(static_cast<Eigen::Index>(bearings_.size()), static_cast<Eigen::Index>(first.back()));
  for (std::size_t b = 0; b < bearings_.size(); ++b) {
    const auto& [one, two] = bearings_[b].bodies;
    const std::array<const PartMotion*, 2> bodies{&part_of(one, parts), &part_of(two, parts)};
    for (std::size_t side = 0; side < 2; ++side) {
      const auto& columns = bodies[side]->test_columns;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const BodyMotion<double> still{};
        const auto a = along(bodies[0]->value, side == 0 ? columns[k] : still);
        const auto c = along(bodies[1]->value, side == 1 ? columns[k] : still);
        const auto body = static_cast<std::size_t>(bearings_[b].bodies[side]);
        result(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(first[body] + k)) =
            std::visit([&](const auto& joint) { return coordinate_of(joint, a, c).slope; }, bearings_[b].coordinate);
      }
    }
  }
  return result;
}

// phi = G^T lambda + D^T s, D the slopes and s any friction: with the projection P = I - D^T (D D^T)^-1 D, which
// removes D^T s, (G P G^T) lambda = G P phi. Where the joints determine a rate of D, as in loops with more bearings
// than free motions, that matrix is singular. There s is the friction in force, which phi contains: G^T lambda = phi.
void JointBearings::measure(std::span<const PartMotion> parts, const JointSystem& joints,
                            const JointSystem::Given& given, const JointSystem::Vector& phi) {
  JointSystem::Vector g;
  JointDerivative G;
  joints.configuration(parts, JointSystem::Along::test_columns, given, g, G);
  const JointSystem::Matrix D = slopes(parts, joints.first());
  const JointSystem::Vector lambda = forces_of_joints(G.dense(), D, phi);
  std::vector<Vector3<double>> points;
  for (const JointBearing& bearing : bearings_) {
    points.resize(std::max(points.size(), bearing.joint + 1));
    points[bearing.joint] = bearing.point;
  }
  points.resize(std::max(points.size(), joints.num_joints()));
  const auto reactions = joints.reactions(parts, given, lambda, points);
  for (std::size_t b = 0; b < bearings_.size(); ++b) {
    const JointBearing& bearing = bearings_[b];
    const Vector3<double> n = part_of(bearing.bodies[1], parts).value.direction(bearing.axis);
    *largest_[b] = largest_friction(bearing, reactions[bearing.joint], n);
  }
}

}  // namespace pliant
