/// Forces at nodes that a program gives while a simulation runs; U = -f . u.
#pragma once

#include "energy/term.hpp"

#include <span>
#include <vector>

namespace pliant {

/// Forces that stay until they are replaced: another solver's, or a controller's. They count as loads whose work is
/// booked, because they may change from step to step.
class NodalForces final : public EnergyTerm {
 public:
  /// None, on so many owned nodes.
  explicit NodalForces(PetscInt num_owned_nodes) : forces_(3 * static_cast<std::size_t>(num_owned_nodes), 0.0) {}

  std::string_view name() const override { return "nodal forces"; }
  TermDeclaration declaration() const override { return {.account = Account::load}; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter&, Projection) const override {}

  /// xyz per owned node [N]; a static problem multiplies them by its load factor.
  std::span<double> forces() { return forces_; }

 private:
  std::vector<double> forces_;
};

}  // namespace pliant
