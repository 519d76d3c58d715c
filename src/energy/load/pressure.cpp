#include "energy/load/pressure.hpp"

namespace pliant {

FollowerPressure::FollowerPressure(const NodeLayout& layout, const BlockPattern& pattern, FacetList facets,
                                   Expression pressure, Rim rim)
    : surface_(layout, pattern, std::move(facets), pressure.depends_on_space() ? 4 : 0),
      pressure_(std::move(pressure)),
      rim_(rim) {}

TermDeclaration FollowerPressure::declaration() const {
  if (!has_potential()) return {.is_potential = false, .symmetry = Symmetry::unsymmetric, .account = Account::load};
  // If the rim moves, its path matters, not only its position.
  if (rim_ == Rim::moving) return {.account = Account::load};
  const bool changes = pressure_.depends_on_time();
  return {.account = changes ? Account::load : Account::load_potential, .has_load_energy = true};
}

std::vector<double> FollowerPressure::pressures(const LocalStage& stage) const {
  auto result = surface_.weighted(pressure_, stage.time);
  for (double& p : result) p *= stage.load_factor;
  return result;
}

double FollowerPressure::value(const LocalStage& stage, std::span<const double> q) const {
  return has_potential() ? surface_.work(pressures(stage), stage.q0, q) : 0.0;
}

double FollowerPressure::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  if (!declaration().has_load_energy) return 0.0;
  return at.load_factor * surface_.work(surface_.weighted(pressure_, at.time), std::vector<double>(q.size(), 0.0), q);
}

void FollowerPressure::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  surface_.add_forces(pressures(stage), q, r);
}

void FollowerPressure::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                                   Projection projection) const {
  if (projection == Projection::none) surface_.add_tangent(pressures(stage), q, K);
}

}  // namespace pliant
