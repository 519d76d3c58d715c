#include "energy/load/body_torque.hpp"

#include "fem/straight_cell.hpp"

#include <utility>

namespace pliant {

BodyTorque::BodyTorque(const NodeLayout& layout, PetscInt cell, std::array<Expression, 3> value)
    : num_owned_nodes_(layout.num_owned_nodes), value_(std::move(value)) {
  if (cell < 0) return;
  const auto corners = layout.nodes_of_cell(cell).first(4);
  nodes_.assign(corners.begin(), corners.end());
  std::array<Vector3<double>, 4> X;
  for (std::size_t a = 0; a < 4; ++a) X[a] = layout.position(corners[a]);
  gradients_ = linear_gradients(X);
}

Vector3<double> BodyTorque::torque(const LocalStage& stage) const {
  Vector3<double> tau{};
  for (std::size_t i = 0; i < 3; ++i) tau[i] = stage.load_factor * value_[i](0.0, 0.0, 0.0, stage.time);
  return tau;
}

// F grad N_a = grad N_a + sum_b u_b (grad N_b . grad N_a).
void BodyTorque::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const Vector3<double> tau = torque(stage);
  for (std::size_t a = 0; a < nodes_.size(); ++a) {
    if (nodes_[a] >= num_owned_nodes_) continue;
    Vector3<double> arm = gradients_[a];
    for (std::size_t b = 0; b < 4; ++b) {
      const auto* u = &q[3 * static_cast<std::size_t>(nodes_[b])];
      arm = arm + dot(gradients_[a], gradients_[b]) * Vector3<double>{u[0], u[1], u[2]};
    }
    const Vector3<double> force = 0.5 * cross(tau, arm);
    for (std::size_t i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(nodes_[a]) + i] -= force[i];
  }
}

void BodyTorque::add_hessian(const LocalStage& stage, std::span<const double> /*q*/, const BlockWriter& K,
                             Projection projection) const {
  if (projection != Projection::none) return;
  const auto [x, y, z] = torque(stage);
  for (std::size_t a = 0; a < nodes_.size(); ++a) {
    if (nodes_[a] >= num_owned_nodes_) continue;
    for (std::size_t b = 0; b < 4; ++b) {
      const double s = -0.5 * dot(gradients_[a], gradients_[b]);
      K.add(nodes_[a], nodes_[b], std::array{0.0, -s * z, s * y, s * z, 0.0, -s * x, -s * y, s * x, 0.0});
    }
  }
}

}  // namespace pliant
