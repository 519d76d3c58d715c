#include "energy/load/tendon_friction.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

double angle_between(const Vector3<double>& a, const Vector3<double>& b) {
  return std::atan2(norm(cross(a, b)), dot(a, b));
}

}  // namespace

TermDeclaration TendonFriction::declaration() const {
  TermDeclaration declaration;
  declaration.refreezes = true;
  declaration.account = Account::stored;
  declaration.rotates_with_body = false;
  declaration.dissipates = true;
  return declaration;
}

DragResponse TendonFriction::response(const Turn& turn) const {
  const Friction full{1.0, 0.0, friction_.stick_velocity};
  return full(turn.drop, {0.0, 0.0, 1.0}, {turn.velocity, 0.0, 0.0});
}

std::vector<TendonFriction::Turn> TendonFriction::turns(const LocalStage& stage, std::span<const double> q) const {
  const auto& segments = TendonPath::segments(*stage.near);
  const std::span<const double> frozen = stage.frozen_at(true, q);
  std::vector<Turn> turns(segments.size());
  std::vector<double> frozen_velocities(segments.size());
  double beyond = 0.0, frozen_beyond = 0.0, lengthening = 0.0;
  for (std::size_t k = segments.size(); k-- > 0;) {
    turns[k].n = unit(segments[k].way(frozen));
    beyond -= dot(turns[k].n, segments[k].change(q, stage.q0)) / stage.dt;
    frozen_beyond -= dot(turns[k].n, segments[k].change(frozen, stage.q0)) / stage.dt;
    turns[k].velocity = beyond;
    frozen_velocities[k] = frozen_beyond;
    lengthening += segments[k].lengthening(frozen, {});
  }
  double T = std::max(0.0, tension_at_pulled_end(drive_, lengthening, stage.time, stage.load_factor));
  for (std::size_t k = 1; k < segments.size(); ++k) {
    const double most = friction_.coefficient * angle_between(turns[k - 1].n, turns[k].n);
    const double f = response({{}, 1.0, frozen_velocities[k]}).slope[0];
    // T_{k-1} - T_k = F f, also in the limit of f = 0.
    turns[k].drop = f != 0.0 ? T * -std::expm1(-most * f) / f : T * most;
    T *= std::exp(-most * f);
  }
  return turns;
}

std::vector<double> TendonFriction::tensions(double at_pulled_end, std::span<const Vector3<double>> places,
                                             std::span<const Vector3<double>> velocities) const {
  const std::size_t last = places.size() - 1;
  std::vector<Vector3<double>> n(last);
  std::vector<double> slip(last);
  double beyond = 0.0;
  for (std::size_t k = last; k-- > 0;) {
    n[k] = unit(places[k + 1] - places[k]);
    slip[k] = beyond -= dot(n[k], velocities[k + 1] - velocities[k]);
  }
  std::vector<double> T{at_pulled_end};
  for (std::size_t k = 1; k < last; ++k) {
    const double f = response({{}, 1.0, slip[k]}).slope[0];
    T.push_back(T.back() * std::exp(-friction_.coefficient * angle_between(n[k - 1], n[k]) * f));
  }
  return T;
}

double TendonFriction::value(const LocalStage& stage, std::span<const double> q) const {
  const auto& segments = TendonPath::segments(*stage.near);
  const std::vector<Turn> all = turns(stage, q);
  double sum = 0.0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    if (segments[k].is_counted) sum += response(all[k]).potential;
  }
  return stage.dt * sum;
}

// Segment k loses the drops at all points before it.
void TendonFriction::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const auto& segments = TendonPath::segments(*stage.near);
  const std::vector<Turn> all = turns(stage, q);
  double lost = 0.0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    lost += response(all[k]).slope[0];
    segments[k].add_force(*stage.near, -lost * all[k].n, r);
  }
}

// Segments k and l share the points up to the first of them.
void TendonFriction::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                                 Projection /*projection*/) const {
  const auto& segments = TendonPath::segments(*stage.near);
  const std::vector<Turn> all = turns(stage, q);
  std::vector<double> stiffness(all.size(), 0.0);  // sum of F f' / dt up to each point
  for (std::size_t k = 1; k < all.size(); ++k) {
    stiffness[k] = stiffness[k - 1] + response(all[k]).hessian(0, 0) / stage.dt;
  }
  for (std::size_t k = 1; k < all.size(); ++k) {
    for (std::size_t l = 1; l < all.size(); ++l) {
      const double c = stiffness[std::min(k, l)];
      if (c == 0.0) continue;
      for (std::size_t a = 0; a < segments[k].nodes.size(); ++a) {
        if (!stage.near->is_owned(segments[k].nodes[a])) continue;
        for (std::size_t b = 0; b < segments[l].nodes.size(); ++b) {
          std::array<double, 9> block{};
          const double factor = c * segments[k].weights[a] * segments[l].weights[b];
          for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = factor * all[k].n[i] * all[l].n[j];
          }
          K.add(segments[k].nodes[a], segments[l].nodes[b], block);
        }
      }
    }
  }
}

double TendonFriction::dissipation(const LocalStage& stage, std::span<const double> q) const {
  const auto& segments = TendonPath::segments(*stage.near);
  const std::vector<Turn> all = turns(stage, q);
  double sum = 0.0;
  for (std::size_t k = 1; k < all.size(); ++k) {
    if (segments[k].is_counted) sum += response(all[k]).slope[0] * all[k].velocity;
  }
  return sum;
}

}  // namespace pliant
