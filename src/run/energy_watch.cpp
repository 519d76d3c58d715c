#include "run/energy_watch.hpp"

#include <algorithm>

namespace pliant {

void EnergyWatch::look(const Energies& energies, double time, double rounding) {
  rounding_ = std::max(rounding_, rounding);
  const double supplied = start_ + energies.load_work - energies.load_potential;
  const double created = energies.kinetic + energies.elastic - supplied;
  supplied_ = std::max(supplied_, supplied);
  if (created > created_) {
    created_ = created;
    created_at_ = time;
  }
  if (created + energies.dissipated > created_with_dissipation_) {
    created_with_dissipation_ = created + energies.dissipated;
    created_with_dissipation_at_ = time;
  }
}

std::optional<EnergyWatch::Growth> EnergyWatch::growth() const {
  if (!(supplied_ > 0.0) || sees_only_rounding()) return std::nullopt;
  if (created_ > tolerance * supplied_) return Growth{1.0 + created_ / supplied_, created_at_};
  if (created_with_dissipation_ > tolerance_with_dissipation * supplied_)
    return Growth{1.0 + created_with_dissipation_ / supplied_, created_with_dissipation_at_, true};
  return std::nullopt;
}

std::optional<EnergyWatch::Loss> EnergyWatch::loss(const Energies& end) const {
  const Loss loss{end.numerical_dissipation, supplied_};
  if (sees_only_rounding()) return std::nullopt;
  constexpr double rounding = 1e-9;
  const double size = end.kinetic + std::abs(end.elastic) + std::abs(end.load_work);
  if (!(loss.dissipated > std::max(tolerated_loss * supplied_, rounding * size)) || !(supplied_ > 0.0)) {
    return std::nullopt;
  }
  return loss;
}

void EnergyWatch::keep(Archive& archive) {
  const Archive::Section section(archive, "energy_watch");
  archive.number("start", start_);
  archive.number("came_in", supplied_);
  archive.number("made", created_);
  archive.number("made_at", created_at_);
  archive.number("made_in_all", created_with_dissipation_);
  archive.number("made_in_all_at", created_with_dissipation_at_);
}

}  // namespace pliant
