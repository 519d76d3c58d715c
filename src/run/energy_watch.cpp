#include "run/energy_watch.hpp"

#include <algorithm>

namespace pliant {

void EnergyWatch::look(const Energies& energies, double time) {
  const double came_in = start_ + energies.load_work - energies.load_potential;
  const double made = energies.kinetic + energies.elastic - came_in;
  came_in_ = std::max(came_in_, came_in);
  if (made > made_) {
    made_ = made;
    made_at_ = time;
  }
  if (made + energies.dissipated > made_in_all_) {
    made_in_all_ = made + energies.dissipated;
    made_in_all_at_ = time;
  }
}

std::optional<EnergyWatch::Growth> EnergyWatch::growth() const {
  if (!(came_in_ > 0.0)) return std::nullopt;
  if (made_ > tolerance * came_in_) return Growth{1.0 + made_ / came_in_, made_at_};
  if (made_in_all_ > tolerance_in_all * came_in_) return Growth{1.0 + made_in_all_ / came_in_, made_in_all_at_, true};
  return std::nullopt;
}

void EnergyWatch::keep(Archive& archive) {
  const Archive::Section section(archive, "energy_watch");
  archive.number("start", start_);
  archive.number("came_in", came_in_);
  archive.number("made", made_);
  archive.number("made_at", made_at_);
  archive.number("made_in_all", made_in_all_);
  archive.number("made_in_all_at", made_in_all_at_);
}

}  // namespace pliant
