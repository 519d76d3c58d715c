/// How stiff the stops of joints with limits are.
#pragma once

#include "energy/rigid/joint_effort.hpp"
#include "input/config.hpp"
#include "model/mechanisms.hpp"

#include <array>
#include <vector>

namespace pliant {

/// The angle of a hinge or the travel of a slider.
JointCoordinate coordinate_of_joint(const ModelJoint& joint);

/// How far a joint is beyond its stops [rad] or [m]; negative: between them. Collective.
double beyond_stops(const JointStops& stops, const ModelJoint& joint, Vec q, Vec v);

/// The stops of a joint with limits between rigid bodies (numbers among those of `config`; JointEquation::ground). What
/// the input does not give follows from masses and the step: a body that strikes a stop is thrown back after a few
/// steps. Throws InputError where there are none. Collective.
JointStops make_joint_stops(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                            const JointConfig& given, const ModelJoint& joint, const std::array<int, 2>& bodies);

}  // namespace pliant
