#include "energy/volume/mass_damping.hpp"

namespace pliant {
namespace {

std::vector<double> velocity(const LocalStage& stage, std::span<const double> q) {
  std::vector<double> v(q.size());
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = (q[i] - stage.q0[i]) / stage.dt;
  return v;
}

}  // namespace

double MassDamping::value(const LocalStage& stage, std::span<const double> q) const {
  return 0.5 * stage.dt * dissipation(stage, q);
}

void MassDamping::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  matrix_.add_times(velocity(stage, q), r);
}

void MassDamping::add_hessian(const LocalStage& stage, std::span<const double>, const BlockWriter& K,
                              Projection) const {
  matrix_.add_to(1.0 / stage.dt, K);
}

void MassDamping::pull_back(const LocalStage& stage, std::span<const double> /*q*/, const StageMultipliers& m,
                            const StageSlopes& slopes) const {
  std::vector<double> d(m.residual.begin(), m.residual.end());
  for (double& x : d) x *= -1.0 / stage.dt;
  matrix_.add_times(d, slopes.q0);
}

void MassDamping::add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                                 std::span<double> works) const {
  of_cells_(d, velocity(stage, q), works);
}

double MassDamping::dissipation(const LocalStage& stage, std::span<const double> q) const {
  const std::vector<double> v = velocity(stage, q);
  return matrix_.product(v, v);
}

}  // namespace pliant
