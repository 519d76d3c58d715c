#include "energy/load/cavity.hpp"

namespace pliant {
namespace {

LoadState load_state(const LocalStage& stage) {
  return {stage.time, stage.load_factor};
}

}  // namespace

TermDeclaration Cavity::declaration() const {
  const bool changes = std::visit([](const auto& of) { return of.depends_on_time(); }, content_);
  return {.account = changes ? Account::load : Account::load_potential, .has_load_energy = true};
}

double Cavity::pressure(double S, const LoadState& at) const {
  return std::visit([&](const auto& of) { return of.pressure(S, at); }, content_);
}

double Cavity::swept(std::span<const double> q) const {
  return walls_.work(walls_.weighted(1.0), std::vector<double>(q.size(), 0.0), q);
}

SumOverRanks Cavity::part(const LocalStage& stage, std::span<const double> q) const {
  return {swept(stage.q0), walls_.work(walls_.weighted(1.0), stage.q0, q)};
}

void Cavity::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const double p = pressure(stage.sum.total(), load_state(stage));
  walls_.add_forces(walls_.weighted(p), q, r);
}

void Cavity::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                         Projection projection) const {
  if (projection == Projection::positive_semidefinite) return;
  const double p = pressure(stage.sum.total(), load_state(stage));
  walls_.add_tangent(walls_.weighted(p), q, K);
}

double Cavity::value_of_sum(const LocalStage& stage) const {
  const auto work = [&](const auto& of) { return of.work(stage.sum.start, stage.sum.change, load_state(stage)); };
  return std::visit(work, content_);
}

double Cavity::energy_of_sum(const Instant& at, double S) const {
  return std::visit([&](const auto& of) { return of.work(0.0, S, {at.time, at.load_factor}); }, content_);
}

double Cavity::curvature(const LocalStage& stage) const {
  const auto stiffness = [&](const auto& of) { return of.stiffness(stage.sum.total(), load_state(stage)); };
  return std::visit(stiffness, content_);
}

void Cavity::add_gradient_of_sum(const LocalStage& /*stage*/, std::span<const double> q, std::span<double> g) const {
  walls_.add_forces(walls_.weighted(1.0), q, g);
}

}  // namespace pliant
