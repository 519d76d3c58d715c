#include "energy/rod/rod_viscosity.hpp"

namespace pliant {
namespace {

/// s_k' of a stencil.
template <class Stencil>
double rate_of(const Stencil& stencil, std::size_t k, double dt) {
  double rate = 0.0;
  for (std::size_t i = 0; i < stencil.change.size(); ++i) rate += stencil.strains[k].slope[i] * stencil.change[i];
  return rate / dt;
}

}  // namespace

TermDeclaration RodViscosity::declaration() const {
  TermDeclaration declaration = viscous_force;
  declaration.rotates_with_body = false;
  return declaration;
}

template <int order, class Visit>
void RodViscosity::for_each(const LocalStage& stage, std::span<const double> q, const Visit& visit) const {
  if (stage.q0.empty() || !(stage.dt > 0.0)) return;
  const auto& here = Rods::seen(stage.near);
  const auto visit_part = [&](const auto& part, double damping, bool is_counted) {
    if (damping == 0.0) return;
    auto stencil = rods_.stencil<order>(part, q, stage.q0);
    for (double& resistance : stencil.stiffness) resistance *= damping;
    visit(stencil, is_counted);
  };
  for (const auto& segment : here.segments) {
    visit_part(segment, rods_.segments_[segment.number].damping, segment.is_counted);
  }
  for (const auto& vertex : here.vertices) {
    visit_part(vertex, rods_.vertices_[rods_.number_of(vertex)].damping, vertex[0].is_counted);
  }
}

void RodViscosity::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  for_each<1>(stage, q, [&](const auto& stencil, bool /*is_counted*/) {
    auto force = stencil.change;
    force.fill(0.0);
    for (std::size_t k = 0; k < stencil.strains.size(); ++k) {
      const double f = stencil.stiffness[k] * rate_of(stencil, k, stage.dt);
      for (std::size_t i = 0; i < force.size(); ++i) force[i] += f * stencil.strains[k].slope[i];
    }
    scatter_gradient(stencil.nodes, force, rods_.num_owned_nodes_, r);
  });
}

void RodViscosity::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                               Projection projection) const {
  const double exact = projection == Projection::none ? 1.0 : 0.0;
  for_each<2>(stage, q, [&]<class Stencil>(const Stencil& stencil, bool /*is_counted*/) {
    constexpr std::size_t N = std::tuple_size_v<decltype(stencil.change)>;
    std::array<double, N * N> hessian{};
    for (std::size_t k = 0; k < stencil.strains.size(); ++k) {
      const auto& s = stencil.strains[k];
      const double c = stencil.stiffness[k], rate = rate_of(stencil, k, stage.dt);
      std::array<double, N> slope_of_rate{};  // ds'/dx
      for (std::size_t j = 0; j < N; ++j) {
        double bent = 0.0;
        for (std::size_t i = 0; i < N; ++i) bent += s.bend_of(i, j) * stencil.change[i];
        slope_of_rate[j] = (s.slope[j] + exact * bent) / stage.dt;
      }
      for (std::size_t i = 0; i < N; ++i) {
        for (std::size_t j = 0; j < N; ++j) {
          hessian[N * i + j] += c * (s.slope[i] * slope_of_rate[j] + exact * rate * s.bend_of(i, j));
        }
      }
    }
    scatter_hessian(stencil.nodes, hessian, rods_.num_owned_nodes_, K);
  });
}

double RodViscosity::dissipation(const LocalStage& stage, std::span<const double> q) const {
  double power = 0.0;
  for_each<1>(stage, q, [&](const auto& stencil, bool is_counted) {
    for (std::size_t k = 0; k < stencil.strains.size() && is_counted; ++k) {
      const double rate = rate_of(stencil, k, stage.dt);
      power += stencil.stiffness[k] * rate * rate;
    }
  });
  return power;
}

}  // namespace pliant
