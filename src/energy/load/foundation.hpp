/// Foundations (Robin boundary conditions): springs and dashpots between a body and the ground.
#pragma once

#include "base/tensor.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"
#include "material/foundation.hpp"

#include <cstdint>
#include <vector>

namespace pliant {

/// M of |u|_M^2 = int u . D u dA, D = I or N N^T (for a surface [m^2]), or sum u . u (for nodes [1]): blocks of owned
/// rows.
struct FoundationMatrix {
  struct Block {
    PetscInt row, column;  ///< local nodes
    std::int32_t number;   ///< index in the pattern
    Tensor3<double> value;
  };
  std::vector<Block> blocks;
};

/// A foundation (Robin boundary condition) on a surface; either of its sides may be outside.
FoundationMatrix surface_foundation(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                                    FoundationDirection direction);

/// A foundation at owned nodes, each with the same weight.
FoundationMatrix nodal_foundation(const BlockPattern& pattern, const std::vector<PetscInt>& nodes, double weight);

/// U = k/2 |q|_M^2 and R = c/2 |v|_M^2 with the velocity v = (q - q0)/dt of the stage, so that
///
///     Phi = k/2 |q|_M^2 + dt R,    r = M (k q + c v),    K = (k + c/dt) M
///
/// The velocity is linear in q: every method keeps its order, and there is a potential.
class Foundation final : public EnergyTerm {
 public:
  Foundation(FoundationMatrix matrix, const FoundationStiffness& stiffness)
      : matrix_(std::move(matrix)), stiffness_(stiffness) {}

  std::string_view name() const override { return "foundation"; }
  TermDeclaration declaration() const override {
    return {.account = Account::stored, .dissipates = stiffness_.dashpot > 0.0};
  }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy(std::span<const double> q, std::span<const double> z) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;
  bool has_adjoint() const override { return true; }
  void pull_back(const LocalStage& stage, std::span<const double> q, const StageMultipliers& m,
                 const StageSlopes& slopes) const override;

 private:
  FoundationMatrix matrix_;
  FoundationStiffness stiffness_;
};

}  // namespace pliant
