#include "energy/load/spring.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// The lines that a rank sees.
struct LinesSeen final : PairFeatures {
  std::vector<PointLine> lines;
};

/// Below this part of the rest length (and at 0) two points are one, and the line between them has no direction.
constexpr double shortest = 1e-12;

/// A line at a configuration: its length, and its direction if it has one.
struct Extent {
  double length = 0.0;
  Vector3<double> n{};
};

Extent extent_of(const Vector3<double>& d, double rest) {
  const double length = norm(d);
  return {length, length > shortest * rest ? (1.0 / length) * d : Vector3<double>{}};
}

bool has_direction(const Extent& line) {
  return dot(line.n, line.n) > 0.0;
}

/// A rest length that differs from the length in the reference configuration by less than this part of it is that.
constexpr double same_length = 1e-14;

/// l - l0, with the digits of small displacements.
double signed_extension(const LineSpring& spring, const PointLine& line, std::span<const double> q) {
  const double at_rest = norm(line.at_rest), e = at_rest - spring.rest;
  return (std::abs(e) <= same_length * at_rest ? 0.0 : e) + line.lengthening(q, {});
}

/// l - l0 where the spring pulls or pushes.
double extension(const LineSpring& spring, const PointLine& line, std::span<const double> q) {
  const double e = signed_extension(spring, line, q);
  return spring.is_tension_only ? std::max(e, 0.0) : e;
}

/// along n n^T + across (I - n n^T).
std::array<double, 9> block_of(const Vector3<double>& n, double along, double across) {
  std::array<double, 9> block{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      block[3 * i + j] = along * n[i] * n[j] + across * ((i == j ? 1.0 : 0.0) - n[i] * n[j]);
    }
  }
  return block;
}

/// A damper in a stage.
struct DamperState {
  Extent line;
  Vector3<double> velocity{};  // d' [m/s]
  double rate = 0.0;           // l' [m/s]
};

DamperState state_of_damper(const PointLine& pair, const LocalStage& stage, std::span<const double> q, double rest) {
  DamperState state{extent_of(pair.way(q), rest), {}, 0.0};
  if (stage.q0.empty() || !(stage.dt > 0.0)) return state;
  state.velocity = (1.0 / stage.dt) * pair.change(q, stage.q0);
  state.rate = dot(state.line.n, state.velocity);
  return state;
}

}  // namespace

double LineSpring::elastic_force(double length) const {
  return stiffness * (is_tension_only ? std::max(length - rest, 0.0) : length - rest);
}

double LineSpring::force(const Vector3<double>& d, const Vector3<double>& rate) const {
  return elastic_force(norm(d)) + damping * dot(extent_of(d, rest).n, rate);
}

LineTerm::LineTerm(const NodeLayout& layout, std::span<const AttachedPoint> points, std::vector<LineSpring> springs)
    : pairs_(layout, points), springs_(std::move(springs)) {}

std::shared_ptr<const PairFeatures> LineTerm::features_of(const NearPatches& near) const {
  auto seen = std::make_shared<LinesSeen>();
  seen->lines = pairs_.seen(near);
  return seen;
}

const std::vector<PointLine>& LineTerm::lines(const NearPatches& near) {
  return static_cast<const LinesSeen&>(*near.features).lines;
}

TermDeclaration Springs::declaration() const {
  TermDeclaration declaration;
  declaration.rotates_with_body = false;
  return declaration;
}

// k/2 (e^2 - e0^2) = k/2 (e - e0) (e + e0), e - e0 = |d| - |d0|: small changes keep their digits.
double Springs::value(const LocalStage& stage, std::span<const double> q) const {
  double sum = 0.0;
  for (const PointLine& line : lines(*stage.near)) {
    if (!line.is_counted) continue;
    const LineSpring& spring = spring_of(line);
    const double e = extension(spring, line, q), e0 = extension(spring, line, stage.reference());
    const bool always_acts = !spring.is_tension_only || (e > 0.0 && e0 > 0.0);
    const double change = always_acts ? line.lengthening(q, stage.reference()) : e - e0;
    sum += 0.5 * spring.stiffness * change * (e + e0);
  }
  return sum;
}

void Springs::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  for (const PointLine& pair : lines(*stage.near)) {
    const LineSpring& spring = spring_of(pair);
    const Extent line = extent_of(pair.way(q), spring.rest);
    pair.add_force(*stage.near, spring.stiffness * extension(spring, pair, q) * line.n, r);
  }
}

void Springs::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                          Projection projection) const {
  for (const PointLine& pair : lines(*stage.near)) {
    const LineSpring& spring = spring_of(pair);
    const Extent line = extent_of(pair.way(q), spring.rest);
    const double e = signed_extension(spring, pair, q);
    if (spring.is_tension_only && e < 0.0) continue;
    double across = has_direction(line) ? e / line.length : 1.0;
    if (projection != Projection::none) across = std::max(across, 0.0);
    pair.add_stiffness(*stage.near, block_of(line.n, spring.stiffness, spring.stiffness * across), K);
  }
}

double Springs::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  double sum = 0.0;
  for (const PointLine& line : lines(*at.near)) {
    if (!line.is_counted) continue;
    const double e = extension(spring_of(line), line, q);
    sum += 0.5 * spring_of(line).stiffness * e * e;
  }
  return sum;
}

TermDeclaration Dampers::declaration() const {
  TermDeclaration declaration = viscous_force;
  declaration.rotates_with_body = false;
  return declaration;
}

void Dampers::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  for (const PointLine& pair : lines(*stage.near)) {
    const LineSpring& spring = spring_of(pair);
    const DamperState state = state_of_damper(pair, stage, q, spring.rest);
    pair.add_force(*stage.near, spring.damping * state.rate * state.line.n, r);
  }
}

void Dampers::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                          Projection projection) const {
  if (!(stage.dt > 0.0)) return;
  for (const PointLine& pair : lines(*stage.near)) {
    const LineSpring& spring = spring_of(pair);
    const auto [line, velocity, rate] = state_of_damper(pair, stage, q, spring.rest);
    if (!has_direction(line)) continue;
    const bool is_exact = projection == Projection::none;
    const double c = spring.damping, turning = is_exact ? c * rate / line.length : 0.0;
    std::array<double, 9> block = block_of(line.n, c / stage.dt, turning);
    const Vector3<double> across = (is_exact ? c / line.length : 0.0) * (velocity - rate * line.n);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] += line.n[i] * across[j];
    }
    pair.add_stiffness(*stage.near, block, K);
  }
}

double Dampers::dissipation(const LocalStage& stage, std::span<const double> q) const {
  double sum = 0.0;
  for (const PointLine& pair : lines(*stage.near)) {
    if (!pair.is_counted) continue;
    const LineSpring& spring = spring_of(pair);
    const double rate = state_of_damper(pair, stage, q, spring.rest).rate;
    sum += spring.damping * rate * rate;
  }
  return sum;
}

}  // namespace pliant
