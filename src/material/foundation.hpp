/// What springs and dashpots to the ground give per area, or per node.
#pragma once

namespace pliant {

/// What a foundation resists: every displacement, or the part along the reference normal N.
enum class FoundationDirection { all, normal };

/// Per reference area of a surface, or of each node.
struct FoundationStiffness {
  double spring = 0.0;   ///< k [N/m^3, or N/m]
  double dashpot = 0.0;  ///< c [N s/m^3, or N s/m]
};

}  // namespace pliant
