/// A torque on a rigid body.
#pragma once

#include "base/expression.hpp"
#include "base/vector3.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"

#include <array>
#include <vector>

namespace pliant {

/// A torque tau(t) whose direction is fixed in space. At the corners a of a cell of the body, which moves by
/// x = sum x_a N_a with F = sum x_a grad N_a^T, its forces are f_a = tau x (F grad N_a) / 2: together no force, and the
/// power tau . w of a body that turns, where F is a rotation. They have no potential.
class BodyTorque final : public EnergyTerm {
 public:
  /// `cell`: of the body, -1 on ranks without it; `value`: functions of t [N m].
  BodyTorque(const NodeLayout& layout, PetscInt cell, std::array<Expression, 3> value);

  std::string_view name() const override { return "torque"; }
  TermDeclaration declaration() const override {
    return {.is_potential = false, .symmetry = Symmetry::unsymmetric, .account = Account::load};
  }
  double value(const LocalStage&, std::span<const double>) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;

 private:
  Vector3<double> torque(const LocalStage& stage) const;

  PetscInt num_owned_nodes_;
  std::vector<PetscInt> nodes_;  // 4; empty without the cell
  std::array<Vector3<double>, 4> gradients_{};
  std::array<Expression, 3> value_;
};

}  // namespace pliant
