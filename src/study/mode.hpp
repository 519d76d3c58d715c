/// The modes of a vibrating model.
#pragma once

#include "solver/eigenpairs.hpp"
#include "study/vibration.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A motion s exp(i w t) of the shape s, s . M s = 1, with w^2 the eigenvalue.
struct Mode {
  enum class Kind {
    vibrates,
    rigid,    ///< costs no energy: the eigenvalue is zero but for rounding errors
    unstable  ///< grows as exp(g t): the eigenvalue is negative, -g^2
  };
  Kind kind = Kind::vibrates;
  double eigenvalue = 0.0;              ///< [1/s^2]
  double frequency = 0.0;               ///< w / 2 pi; 0 unless it vibrates [Hz]
  double growth_rate = 0.0;             ///< g; 0 unless it is unstable [1/s]
  std::optional<double> damping_ratio;  ///< s . C s / (2 w), of the critical damping; of a mode that vibrates
  /// The mass that takes part in a motion of the ground along x, y, z, as a fraction of the whole mass.
  std::array<double, 3> effective_mass{};
  Handle<Vec> shape;  ///< displacements of the nodes, with ghosts [1/sqrt(kg)]
};

/// "mode 3, 12.4 Hz".
std::string label_of(const Mode& mode, std::size_t number);

/// The modes of the pairs, which `vibration` poses. Where eigenvalues agree to rounding errors any combination of their
/// shapes is one too: here those that each have the momentum along one axis alone, as far as there are such, x first,
/// and then angular momenta; of a free body, its translations and rotations. The sign makes the largest component
/// positive. Collective.
std::vector<Mode> modes_of(const Vibration& vibration, const NodeLayout& layout, const Eigenpairs& pairs);

}  // namespace pliant
