/// Springs and dashpots to the ground (Robin boundary condition), per area or per node.
#pragma once

namespace pliant {

/// The displacement that a foundation resists: every displacement, or its component along the reference normal N.
enum class FoundationDirection { all, normal };

/// Constants per reference area of a surface, or of each node.
struct FoundationStiffness {
  double spring = 0.0;   ///< k [N/m^3, or N/m]
  double dashpot = 0.0;  ///< c [N s/m^3, or N s/m]
};

}  // namespace pliant
