/// The springs, dampers, motors, stops and friction of the input's joints.
#pragma once

#include "energy/rigid/joint_effort.hpp"
#include "input/config.hpp"
#include "model/mechanisms.hpp"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// One term for each kind of law that joints have. `config`: with all rigid bodies. Throws InputError at a joint whose
/// bodies are parts of soft ones. In a static analysis rates do nothing. Collective.
std::vector<std::unique_ptr<EnergyTerm>> make_joint_efforts(const Config& config, const NodeLayout& layout,
                                                            const std::vector<int>& body_of_cell,
                                                            std::span<const ModelJoint> joints);

/// What a joint's spring, damper, dry friction and motor exert, those that it has: the columns' endings.
std::vector<std::string> names_of_efforts(const JointConfig& joint, bool is_static);
/// In the same order [N m] or [N]. `factor`: of loads in a static analysis.
std::vector<double> efforts_of(const JointConfig& joint, bool is_static, double coordinate, double rate, double time,
                               double factor);

/// Throws InputError at a formula of a joint or tendon that is not finite at the time [s].
void require_finite_formulas(const Config& config, double time);

}  // namespace pliant
