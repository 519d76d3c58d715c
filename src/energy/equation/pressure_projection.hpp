/// The pressures that belong to displacements by themselves, dPi/dp = 0 (energy/volume/mixed.hpp): a linear problem
/// with the mass matrix of the pressures over the bulk modulus.
#pragma once

#include "energy/volume/mixed.hpp"

#include <span>

#include <petscksp.h>

namespace pliant {

/// C = -d2Pi/dp2 of all terms at an instant, which does not depend on the displacements. Collective.
Handle<Mat> make_compliance(std::span<const MixedTerm* const> terms, const NodeLayout& layout,
                            const PressureLayout& pressures, const Instant& at = {});

/// Whether free displacements feel every pressure: incompressible bodies whose whole surface is held do not feel one
/// that is the same everywhere. `prescribed`: per owned component; `is_idle`: per local pressure, those that are left
/// out. Collective.
bool are_felt(std::span<const MixedTerm* const> terms, const NodeLayout& layout, std::span<const char> prescribed,
              std::span<const char> is_idle);

class PressureProjection {
 public:
  /// Every body must be compressible. Collective.
  explicit PressureProjection(Handle<Mat> compliance);

  /// p = C^-1 r, with r = dPi/dp at p = 0. Collective.
  void solve(Vec r, Vec p);

 private:
  Handle<KSP> solver_;
};

}  // namespace pliant
