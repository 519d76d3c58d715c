#include "model/unresisted_motions.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"
#include "input/loads.hpp"
#include "model/rods.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>

#include <fmt/format.h>

namespace pliant {
namespace {

using Matrix = JointSystem::Matrix;
using Vector = JointSystem::Vector;

constexpr Eigen::Index unknowns_of_part = 6;
/// Squares of motions of the size 1 below this are zero.
constexpr double none = 1e-10;
/// Rotations that are smaller than the largest one by this factor are not mentioned.
constexpr double slight = 0.3;

/// The rigid body of this name, if nothing but joints, weight and forces acts on it.
const RigidBodyConfig* free_body(const Config& config, const std::string& name) {
  const auto body = std::ranges::find(config.rigid_bodies, name, &RigidBodyConfig::name);
  if (body == config.rigid_bodies.end() || !body->attached.empty() || !body->coupled.empty()) return nullptr;
  if ((body->surface && config.contact) || !sections_held_by(config, name).empty()) return nullptr;
  const auto is_at_body = [&](const BodyPoint& point) { return point.body == name; };
  for (const SpringConfig& spring : config.springs) {
    if (std::ranges::any_of(spring.points, is_at_body)) return nullptr;
  }
  for (const TendonConfig& tendon : config.tendons) {
    if (std::ranges::any_of(tendon.points, is_at_body)) return nullptr;
  }
  for (const JointConfig& joint : config.joints) {
    const bool has_rates = analysis_of(config) == Analysis::quasistatic;  // or dampers and friction exert nothing
    const bool resists_rates = joint.damping.value_or(0.0) > 0.0 || joint.friction.value_or(0.0) > 0.0 ||
                               (joint.bearing && joint.bearing->friction > 0.0);
    // A given effort resists nothing.
    const bool motor_resists =
        joint.motor && (joint.motor->stiffness > 0.0 || (has_rates && joint.motor->damping > 0.0));
    const bool has_effort = joint.spring || motor_resists || joint.limits || (has_rates && resists_rates);
    if (has_effort && std::ranges::find(joint.between, name) != joint.between.end()) return nullptr;
  }
  return &*body;
}

/// The motions among `free`, columns in the unknowns of all parts, that move no center of mass and nothing that is
/// held.
Matrix unresisted(const Matrix& free, const Matrix& seen) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(free.transpose() * seen * free);
  Eigen::Index number = 0;
  while (number < solver.eigenvalues().size() && solver.eigenvalues()[number] < none) ++number;
  return free * solver.eigenvectors().leftCols(number);
}

/// A direction as users type it: its largest component positive.
std::string in_words(Vector direction) {
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  direction *= (direction[largest] < 0.0 ? -1.0 : 1.0) / direction.norm();
  const auto rounded = [&](Eigen::Index i) { return std::abs(direction[i]) < 1e-6 ? 0.0 : direction[i]; };
  return fmt::format("[{:.3g}, {:.3g}, {:.3g}]", rounded(0), rounded(1), rounded(2));
}

}  // namespace

std::optional<Diagnostic> find_unresisted_motion(const Config& config, const ConnectedBodies& bodies) {
  // Without loads, as for the modes of vibration about a state at rest, bodies stay where they are.
  const auto is_driving = [](const LoadConfig& load) { return !foundation_of(load); };
  const auto is_driven = [](const JointConfig& joint) { return joint.motor.has_value(); };
  if (analysis_of(config) == Analysis::dynamic) return std::nullopt;
  if (std::ranges::none_of(config.loads, is_driving) && std::ranges::none_of(config.joints, is_driven)) {
    return std::nullopt;
  }
  std::vector<const RigidBodyConfig*> found;
  for (const std::string& name : bodies.names) found.push_back(free_body(config, name));
  const auto first = std::ranges::find_if(found, [](const auto* body) { return body != nullptr; });
  if (first == found.end()) return std::nullopt;
  const auto error = [](const RigidBodyConfig& body, std::string message) {
    return Diagnostic{Severity::error, body.where, std::move(message)};
  };
  const bool is_held = bodies.is_on_ground || std::ranges::find(found, nullptr) != found.end();
  if (!is_held) {
    std::vector<std::string> names;
    for (const std::string& name : bodies.names) names.push_back("'" + name + "'");
    return error(**first, fmt::format("nothing holds {}: a static analysis has no unique equilibrium; add joints or "
                                      "springs to the `ground` or to bodies that are held, a constraint `rigid`, or "
                                      "use a dynamic `time.method`",
                                      joined(names)));
  }
  if (bodies.mechanism == nullptr) return std::nullopt;
  const Matrix& free = bodies.mechanism->free_motions();
  const auto size = unknowns_of_part * static_cast<Eigen::Index>(found.size());
  if (free.cols() == 0 || free.rows() != size) return std::nullopt;  // or motions of parts are prescribed
  Matrix seen = Matrix::Identity(size, size);
  for (std::size_t p = 0; p < found.size(); ++p) {
    const auto rotation = unknowns_of_part * static_cast<Eigen::Index>(p) + 3;
    if (found[p] != nullptr) seen.block(rotation, rotation, 3, 3).setZero();
  }
  const Matrix motions = unresisted(free, seen);
  if (motions.cols() == 0) return std::nullopt;
  // A center that is at rest in one configuration alone, as at a dead center, may be held by its weight. Another
  // configuration: a tenth of the size away, by no two free motions alike.
  Vector moved(free.cols());
  for (Eigen::Index k = 0; k < moved.size(); ++k) moved[k] = 0.1 * std::sin(1.0 + 1.7 * static_cast<double>(k));
  const auto near = bodies.mechanism->free_motions_near(bodies.mechanism->size() * moved);
  if (!near || unresisted(*near, seen).cols() == 0) return std::nullopt;
  const Vector sizes = motions.rowwise().norm();
  const auto rotation_of = [&](std::size_t p) { return unknowns_of_part * static_cast<Eigen::Index>(p) + 3; };
  std::vector<std::string> rotating;
  const RigidBodyConfig* which = nullptr;
  for (std::size_t p = 0; p < found.size(); ++p) {
    if (found[p] == nullptr || sizes.segment(rotation_of(p), 3).norm() < slight * sizes.maxCoeff()) continue;
    if (which == nullptr) which = found[p];
    std::string text = "'" + bodies.names[p] + "'";
    if (motions.cols() == 1) text += " about the axis " + in_words(motions.col(0).segment(rotation_of(p), 3));
    rotating.push_back(std::move(text));
  }
  if (which == nullptr) return std::nullopt;
  return error(*which,
               fmt::format("nothing resists a rotation of {} through the center of mass: no joint prevents it, "
                           "and no force depends on it, so a static analysis has no unique equilibrium; prevent "
                           "it by a joint (`universal` or `hinge` instead of `ball`), hold it by a spring, or "
                           "let it move with a dynamic `time.method`",
                           joined(rotating)));
}

}  // namespace pliant
