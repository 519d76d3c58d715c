/// A segment of a fibre, and its stretch.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include <petscsys.h>

namespace pliant {

/// A segment of a rod that resists nothing but a change of its length.
struct FibreSegment {
  std::array<Vector3<double>, 2> ends{};  ///< at rest [m]
  double length = 0.0;                    ///< [m]
  double axial = 0.0;                     ///< E A [N]
  double mass = 0.0;                      ///< [kg]
  double damping = 0.0;                   ///< viscous resistance per stiffness [s]
};

/// The same on a rank.
struct LocalFibre {
  std::array<PetscInt, 2> nodes{};  ///< local
  Vector3<double> axis{};           ///< t at rest
  Vector3<double> middle{};         ///< at rest [m]
  double length = 0.0, axial = 0.0, mass = 0.0, damping = 0.0;
  std::size_t number = 0;
  bool is_counted = false;  ///< on exactly one rank

  /// t - axis at displacements q.
  Vector3<double> change(std::span<const double> q) const {
    const std::size_t a = 3 * static_cast<std::size_t>(nodes[0]), b = 3 * static_cast<std::size_t>(nodes[1]);
    return (1.0 / length) * Vector3<double>{q[b] - q[a], q[b + 1] - q[a + 1], q[b + 2] - q[a + 2]};
  }
  /// What t is more at q than at `from`, with the digits of small changes.
  Vector3<double> change(std::span<const double> q, std::span<const double> from) const {
    const std::size_t a = 3 * static_cast<std::size_t>(nodes[0]), b = 3 * static_cast<std::size_t>(nodes[1]);
    const auto moved = [&](std::size_t i) { return (q[b + i] - from[b + i]) - (q[a + i] - from[a + i]); };
    return (1.0 / length) * Vector3<double>{moved(0), moved(1), moved(2)};
  }
};

/// The stretch s = |t| - 1 of a segment, with the digits of small ones, and its derivatives by t:
/// n = t / |t| and (I - n n^T) / |t|.
struct FibreStretch {
  double value = 0.0;
  Vector3<double> n{};

  /// `h`: t - axis.
  FibreStretch(const Vector3<double>& axis, const Vector3<double>& h) {
    const double square = dot(h, h) + 2.0 * dot(axis, h);  // |t|^2 - 1
    value = square / (1.0 + std::sqrt(1.0 + square));
    n = (1.0 / (1.0 + value)) * (axis + h);
  }
};

}  // namespace pliant
