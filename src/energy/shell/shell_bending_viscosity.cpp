#include "energy/shell/shell_bending_viscosity.hpp"

#include "base/compensated_sum.hpp"
#include "energy/shell/hinge_sums.hpp"

#include <vector>

namespace pliant {
namespace {

bool moves(const LocalStage& stage) {
  return !stage.q0.empty() && stage.dt > 0.0;
}

std::vector<double> difference(std::span<const double> q, std::span<const double> q0) {
  std::vector<double> result(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) result[i] = q[i] - q0[i];
  return result;
}

/// theta' of all hinges [1/s].
std::vector<double> rates_of_angles(const BendingStencils& seen, std::span<const OfHingeNodes> slopes,
                                    std::span<const double> change, double dt) {
  std::vector<double> rates;
  for (std::size_t h = 0; h < seen.hinges.size(); ++h) {
    rates.push_back(sum_over_nodes(seen.hinges[h], slopes[h], change) / dt);
  }
  return rates;
}

/// k' of a triangle [1/(m s)].
std::array<double, 3> rate_of_curvature(const BendingStencil& stencil, std::span<const double> rates) {
  std::array<double, 3> result{};
  for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
    for (std::size_t i = 0; i < 3; ++i) result[i] += stencil.curvature[h][i] * rates[stencil.hinges[h]];
  }
  return result;
}

}  // namespace

TermDeclaration ShellBendingViscosity::declaration() const {
  TermDeclaration declaration = viscous_force;
  declaration.rotates_with_body = false;
  return declaration;
}

std::array<double, 3> ShellBendingViscosity::moment(const BendingStencil& stencil,
                                                    const std::array<double, 3>& rate) const {
  const auto& [damping, of_trace, of_shear] = resistance_;
  const auto& [D, nu] = stencil.stiffness;
  const double trace = (damping * D * nu + of_trace) * (rate[0] + rate[1]), shear = damping * D * (1.0 - nu) + of_shear;
  return {trace + shear * rate[0], trace + shear * rate[1], 0.5 * shear * rate[2]};
}

void ShellBendingViscosity::add_gradient(const LocalStage& stage, std::span<const double> q,
                                         std::span<double> r) const {
  const BendingStencils& here = BendingStencils::seen(stage.near);
  if (!moves(stage) || here.stencils.empty()) return;
  const auto slopes = slopes_of_angles(here, q);
  const auto rates = rates_of_angles(here, slopes, difference(q, stage.q0), stage.dt);
  std::vector<double> moments(here.hinges.size(), 0.0);
  for (const BendingStencil& stencil : here.stencils) {
    const auto m = moment(stencil, rate_of_curvature(stencil, rates));
    for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
      moments[stencil.hinges[h]] += stencil.area * dot(stencil.curvature[h], m);
    }
  }
  add_moments(here, moments, slopes, bending_.num_owned_nodes(), r);
}

// dr = sum A dtheta_g (G_g . m(G_h)) dtheta_h' + (moment of g) d2theta_g, dtheta' = (dtheta/dx + d2theta/dx2 (x -
// x0))/dt
void ShellBendingViscosity::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                                        Projection projection) const {
  const BendingStencils& here = BendingStencils::seen(stage.near);
  if (!moves(stage) || here.stencils.empty()) return;
  const bool is_exact = projection == Projection::none;
  const auto slopes = slopes_of_angles(here, q);
  const auto change = difference(q, stage.q0);
  const auto rates = rates_of_angles(here, slopes, change, stage.dt);
  std::vector<OfHingeNodes> slopes_of_rates = slopes;
  for (std::size_t h = 0; h < here.hinges.size(); ++h) {
    const OfHingeNodes bend = is_exact ? bend_along(here.hinges[h], q, change) : OfHingeNodes{};
    for (std::size_t k = 0; k < bend.size(); ++k) slopes_of_rates[h][k] = (slopes[h][k] + bend[k]) / stage.dt;
  }
  std::vector<double> moments(here.hinges.size(), 0.0);
  for (const BendingStencil& stencil : here.stencils) {
    constexpr std::size_t width = BendingStencil::most_hinges;
    std::array<double, width * width> M{};
    const auto m = moment(stencil, rate_of_curvature(stencil, rates));
    for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
      const auto of_hinge = moment(stencil, stencil.curvature[h]);
      for (std::size_t g = 0; g < stencil.num_hinges; ++g) {
        M[width * g + h] = stencil.area * dot(stencil.curvature[g], of_hinge);
      }
      moments[stencil.hinges[h]] += stencil.area * dot(stencil.curvature[h], m);
    }
    add_products(stencil, M, slopes, slopes_of_rates, bending_.num_owned_nodes(), K);
  }
  if (!is_exact) return;
  for (std::size_t h = 0; h < here.hinges.size(); ++h) {
    add_bend(here.hinges[h], moments[h], q, bending_.num_owned_nodes(), K);
  }
}

double ShellBendingViscosity::dissipation(const LocalStage& stage, std::span<const double> q) const {
  const BendingStencils& here = BendingStencils::seen(stage.near);
  if (!moves(stage) || here.stencils.empty()) return 0.0;
  const auto rates = rates_of_angles(here, slopes_of_angles(here, q), difference(q, stage.q0), stage.dt);
  CompensatedSum<double> power;
  for (const BendingStencil& stencil : here.stencils) {
    if (!stencil.is_counted) continue;
    const auto rate = rate_of_curvature(stencil, rates);
    power.add(stencil.area * dot(rate, moment(stencil, rate)));
  }
  return power.total();
}

}  // namespace pliant
