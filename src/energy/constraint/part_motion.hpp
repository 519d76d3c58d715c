/// The motion of a rigid part in a stage, with the derivatives that joints need of it.
#pragma once

#include "energy/constraint/rigid_part.hpp"
#include "energy/rigid/joint_system.hpp"

#include <span>
#include <vector>

namespace pliant {

/// The part's motion and its columns, actual and virtual.
PartMotion motion_of_part(const RigidPart& part, std::span<const double> unknowns);

/// The motion moved along the virtual displacement k and the unknown l, which is not the last of the derivatives:
/// x + eps w_k + eps' t_l + eps eps' dw_k / dxi_l, for each k and l from -1 (none) in the order of
/// JointSystem::curvature.
std::vector<BodyMotion<JointSystem::Twice>> twice_moved(const RigidPart& part, const PartMotion& motion,
                                                        std::span<const double> unknowns);

/// w_k . f of each virtual displacement, of the nodes of this rank [N]. `forces`: on its entries.
std::vector<double> forces_on_unknowns(const RigidPart& part, std::span<const double> unknowns,
                                       std::span<const double> forces);

}  // namespace pliant
