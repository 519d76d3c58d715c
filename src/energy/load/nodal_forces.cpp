#include "energy/load/nodal_forces.hpp"

#include "base/compensated_sum.hpp"

namespace pliant {

double NodalForces::value(const LocalStage& stage, std::span<const double> q) const {
  const std::span<const double> from = stage.reference();
  CompensatedSum<double> total;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    if (forces_[i] != 0.0) total.add(-forces_[i] * (q[i] - from[i]));
  }
  return stage.load_factor * total.total();
}

void NodalForces::add_gradient(const LocalStage& stage, std::span<const double> /*q*/, std::span<double> r) const {
  for (std::size_t i = 0; i < forces_.size(); ++i) r[i] -= stage.load_factor * forces_[i];
}

}  // namespace pliant
