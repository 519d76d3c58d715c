#include "energy/load/tendon.hpp"

#include "base/formula_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace pliant {
namespace {

/// How long before the end of a stage, relative to its length, the rate of a formula is taken: at a kink the earlier
/// one counts.
constexpr double aside = 1e-6;

double at_time(const Expression& formula, double time) {
  return formula(0.0, 0.0, 0.0, time);
}

/// By how much the spring is longer than without tension, or shorter if it is slack [m].
double signed_stretch(const TendonSpring& spring, double lengthening, double time, double factor) {
  return lengthening + factor * at_time(spring.pull, time);
}

double stretch(const TendonSpring& spring, double lengthening, double time, double factor) {
  return std::max(0.0, signed_stretch(spring, lengthening, time, factor));
}

}  // namespace

double tension_at_pulled_end(const TendonDrive& drive, double lengthening, double time, double factor) {
  if (const auto* given = std::get_if<GivenTension>(&drive)) {
    const double T = at_time(given->tension, time);
    return factor * (T < 0.0 ? 0.0 : T);  // NaN remains NaN
  }
  const auto& spring = std::get<TendonSpring>(drive);
  return spring.stiffness * stretch(spring, lengthening, time, factor);
}

TermDeclaration Tendon::declaration() const {
  TermDeclaration declaration;
  declaration.rotates_with_body = false;
  if (const auto* given = std::get_if<GivenTension>(&drive_)) {
    declaration.account = given->tension.depends_on_time() ? Account::load : Account::load_potential;
    declaration.has_load_energy = true;
  } else {
    declaration.account = Account::stored;
    declaration.depends_on_time = !spring()->pull.is_zero();  // load steps change even a constant pull
  }
  return declaration;
}

Coupling Tendon::coupling() const {
  if (spring() == nullptr) return static_cast<const PairCoupling*>(path_.get());
  return SumOverPairs{this, path_.get()};
}

double Tendon::tension(const LocalStage& stage) const {
  return tension_at_pulled_end(drive_, stage.sum.total(), stage.time, stage.load_factor);
}

double Tendon::value(const LocalStage& stage, std::span<const double> q) const {
  if (spring() != nullptr) return 0.0;  // all of it is in value_of_sum
  double sum = 0.0;
  for (const PointLine& segment : TendonPath::segments(*stage.near)) {
    if (segment.is_counted) sum += segment.lengthening(q, stage.reference());
  }
  return tension(stage) * sum;
}

void Tendon::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const double T = tension(stage);
  if (T == 0.0) return;
  for (const PointLine& segment : TendonPath::segments(*stage.near)) {
    segment.add_force(*stage.near, T * unit(segment.way(q)), r);
  }
}

void Tendon::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                         Projection projection) const {
  const double T = tension(stage);
  if (T == 0.0 || (projection != Projection::none && T < 0.0)) return;
  for (const PointLine& segment : TendonPath::segments(*stage.near)) {
    const Vector3<double> d = segment.way(q), n = unit(d);
    std::array<double, 9> block{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = T / norm(d) * ((i == j ? 1.0 : 0.0) - n[i] * n[j]);
    }
    segment.add_stiffness(*stage.near, block, K);
  }
}

double Tendon::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  if (spring() != nullptr) return 0.0;  // all of it is in energy_of_sum
  double length = 0.0;
  for (const PointLine& segment : TendonPath::segments(*at.near)) {
    if (segment.is_counted) length += norm(segment.way(q));
  }
  return tension_at_pulled_end(drive_, 0.0, at.time, at.load_factor) * length;
}

double Tendon::supply(const LocalStage& stage, std::span<const double> /*q*/) const {
  if (spring() == nullptr || !spring()->pull.depends_on_time()) return 0.0;
  const auto& segments = TendonPath::segments(*stage.near);
  if (segments.empty() || !segments.front().is_counted) return 0.0;  // one rank counts it
  const TimeJet pull = spring()->pull.derivatives(0.0, 0.0, 0.0, stage.time, stage.time - aside * stage.dt);
  return tension(stage) * stage.load_factor * pull.rate;
}

SumOverRanks Tendon::part(const LocalStage& stage, std::span<const double> q) const {
  SumOverRanks mine;
  for (const PointLine& segment : TendonPath::segments(*stage.near)) {
    if (!segment.is_counted) continue;
    mine.start += segment.lengthening(stage.q0, {});
    mine.change += segment.lengthening(q, stage.q0);
  }
  return mine;
}

// k/2 (b^2 - a^2) = k/2 (b - a) (b + a), where b - a is the change of the sum if neither is slack.
double Tendon::value_of_sum(const LocalStage& stage) const {
  const double a = stretch(*spring(), stage.sum.start, stage.time, stage.load_factor),
               b = stretch(*spring(), stage.sum.total(), stage.time, stage.load_factor);
  return 0.5 * spring()->stiffness * (a > 0.0 && b > 0.0 ? stage.sum.change : b - a) * (a + b);
}

double Tendon::energy_of_sum(const Instant& at, double S) const {
  const double e = stretch(*spring(), S, at.time, at.load_factor);
  return 0.5 * spring()->stiffness * e * e;
}

double Tendon::curvature(const LocalStage& stage) const {
  // A tendon that is just taut resists being pulled.
  return signed_stretch(*spring(), stage.sum.total(), stage.time, stage.load_factor) >= 0.0 ? spring()->stiffness : 0.0;
}

void Tendon::add_gradient_of_sum(const LocalStage& stage, std::span<const double> q, std::span<double> g) const {
  for (const PointLine& segment : TendonPath::segments(*stage.near)) {
    segment.add_force(*stage.near, unit(segment.way(q)), g);
  }
}

}  // namespace pliant
