/// Contact of bodies with an obstacle: a normal response with a potential, and drags (friction, damping) proportional
/// to its pressure.
#pragma once

#include "energy/contact/contact_surface.hpp"
#include "energy/term.hpp"

#include <memory>

namespace pliant {

/// U = int U(d(x, t)) dA, with the distance d to the obstacle, its gradient n and curvature C = dn/dx:
///
///     r_a = -int N_a p n dA,    K_ab = int N_a N_b (U'' n n^T - p C) dA,    dU/dt at fixed q = int p n . v_o dA
///
/// where v_o is the velocity of the obstacle. The sign of C is definite, so -p C is left out where K must be
/// semidefinite and the obstacle is convex.
class Contact final : public EnergyTerm {
 public:
  Contact(std::shared_ptr<const ContactSurface> surface, std::shared_ptr<const Obstacle> obstacle)
      : surface_(std::move(surface)), obstacle_(std::move(obstacle)) {}

  std::string_view name() const override { return "contact"; }
  bool has_adjoint() const override { return true; }
  TermDeclaration declaration() const override {
    return {.account = Account::stored,
            .depends_on_time = obstacle_->moves(),
            .has_moving_obstacle = obstacle_->moves(),
            .is_wall = surface_->law().kind == NormalKind::barrier};
  }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;
  double supply(const LocalStage& stage, std::span<const double> q) const override;
  /// For a barrier: short of where a point would meet the obstacle, whose distance changes no faster than the point
  /// moves.
  double max_step(const LocalStage& stage, std::span<const double> q, std::span<const double> d) const override;

  /// Nodes nearer than twice the displacement, and those of facets with a point as near, count as touching; from five
  /// times on they count as far.
  void follow_obstacle(const LocalStage& stage, std::span<Vector3<double>> displacements,
                       std::span<double> closeness) const override;

  const ContactSurface& surface() const { return *surface_; }
  const Obstacle& obstacle() const { return *obstacle_; }

 private:
  std::shared_ptr<const ContactSurface> surface_;
  std::shared_ptr<const Obstacle> obstacle_;
};

/// The term of a drag (Friction, NormalDamping) with the potential R of the velocity relative to the obstacle, v - v_o:
///
///     Phi = dt int R(p, n; v - v_o) dA,   v = (q - q0)/dt,   v_o at the end of the stage
///
/// p is the recorded pressure; for friction it includes the damping of the same obstacle. p and n are frozen
/// (FrictionUpdate), and so is the place at which v_o is taken. A traction frozen at the last accepted state would keep
/// acting on a surface that has left: StageEquation::refreeze then freezes it again, at the solution.
std::unique_ptr<EnergyTerm> make_friction(std::shared_ptr<const ContactSurface> surface,
                                          std::shared_ptr<const Obstacle> obstacle, const Friction& friction,
                                          const NormalDamping& damping, FrictionUpdate update);
std::unique_ptr<EnergyTerm> make_normal_damping(std::shared_ptr<const ContactSurface> surface,
                                                std::shared_ptr<const Obstacle> obstacle, const NormalDamping& damping,
                                                FrictionUpdate update);

}  // namespace pliant
