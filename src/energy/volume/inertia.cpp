#include "energy/volume/inertia.hpp"

namespace pliant {

double Inertia::value(const LocalStage& stage, std::span<const double> q) const {
  // 1/(2 dt^2) (|q - qt|_M^2 - |q0 - qt|_M^2) = 1/(2 dt^2) d . M (d - 2 dt v0),  d = q - q0, qt = q0 + dt v0
  std::vector<double> d(q.size()), x(q.size());
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = q[i] - stage.q0[i];
    x[i] = d[i] - 2.0 * stage.dt * stage.v0[i];
  }
  return 0.5 * mass_.product(d, x) / (stage.dt * stage.dt);
}

std::vector<double> Inertia::acceleration(const LocalStage& stage, std::span<const double> q) {
  const double factor = 1.0 / (stage.dt * stage.dt);
  std::vector<double> a(q.size());
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = factor * ((q[i] - stage.q0[i]) - stage.dt * stage.v0[i]);
  return a;
}

void Inertia::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  mass_.add_times(acceleration(stage, q), r);
}

void Inertia::add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                             std::span<double> works) const {
  of_cells_(d, acceleration(stage, q), works);
}

void Inertia::add_hessian(const LocalStage& stage, std::span<const double>, const BlockWriter& K, Projection) const {
  mass_.add_to(1.0 / (stage.dt * stage.dt), K);
}

bool Inertia::set_hessian(const LocalStage& stage, const BlockWriter& K) const {
  mass_.assign_to(1.0 / (stage.dt * stage.dt), K);
  return true;
}

void Inertia::pull_back(const LocalStage& stage, std::span<const double> /*q*/, const StageMultipliers& m,
                        const StageSlopes& slopes) const {
  std::vector<double> d(m.residual.begin(), m.residual.end());
  for (double& x : d) x *= -1.0 / stage.dt;
  mass_.add_times(d, slopes.v0);
  for (double& x : d) x /= stage.dt;
  mass_.add_times(d, slopes.q0);
}

Momenta Inertia::momenta(std::span<const double> X, std::span<const double> q, std::span<const double> v) const {
  std::vector<double> p(v.size(), 0.0);
  mass_.add_times(v, p);
  Momenta result;
  for (PetscInt a = 0; a < num_owned_nodes_; ++a) {
    std::array<double, 3> x;
    for (int i = 0; i < 3; ++i) {
      x[i] = X[3 * a + i] + q[3 * a + i];
      result.linear[i] += p[3 * a + i];
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      result.angular[i] += x[j] * p[3 * a + k] - x[k] * p[3 * a + j];
    }
  }
  return result;
}

template <int Order>
std::unique_ptr<Inertia> make_inertia(const NodeLayout& layout, const BlockPattern& pattern,
                                      const CellGroups<Order>& groups, const std::vector<double>& densities,
                                      Mass mass) {
  return std::make_unique<Inertia>(layout, make_mass_matrix(layout, pattern, groups, densities, mass),
                                   make_cell_mass_products(layout, groups, densities, mass));
}

template std::unique_ptr<Inertia> make_inertia<1>(const NodeLayout&, const BlockPattern&, const CellGroups<1>&,
                                                  const std::vector<double>&, Mass);
template std::unique_ptr<Inertia> make_inertia<2>(const NodeLayout&, const BlockPattern&, const CellGroups<2>&,
                                                  const std::vector<double>&, Mass);

}  // namespace pliant
