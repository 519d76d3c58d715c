/// Motions of rigid bodies that nothing resists.
#pragma once

#include "energy/constraint/mechanism.hpp"
#include "input/config.hpp"

#include <optional>
#include <span>
#include <string>

namespace pliant {

/// Rigid bodies that joints connect.
struct ConnectedBodies {
  std::vector<std::string> names;        ///< of the parts of the mechanism, in their order
  const Mechanism* mechanism = nullptr;  ///< nullptr: a body without joints
  bool is_on_ground = false;             ///< whether a joint connects one with the ground
};

/// For an analysis without inertia, with loads: an error about motions of bodies that no joint forbids and no force
/// resists or drives, so that the equilibrium is not unique; nothing if there are none. These are rotations of bodies
/// about their centers of mass while all centers are at rest, and any motion of bodies that nothing holds. Bodies at
/// which soft bodies, springs, tendons, motors, stops or contact may act count as held. Collective.
std::optional<Diagnostic> find_unresisted_motion(const Config& config, const ConnectedBodies& bodies);

}  // namespace pliant
