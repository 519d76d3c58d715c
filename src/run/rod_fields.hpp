/// Stress resultants of rods at the states of a run.
#pragma once

#include "model/model.hpp"
#include "run/simulation.hpp"

#include <array>
#include <vector>

namespace pliant {

/// What a section carries.
struct RodResultants {
  double force = 0.0;           ///< along the axis, positive in tension [N]
  double bending_moment = 0.0;  ///< magnitude [N m]
  double torque = 0.0;          ///< about the axis [N m]
};

/// The segments of all rods by their numbers, the same on every rank.
struct RodState {
  std::vector<RodResultants> middles;              ///< in the middle of each segment
  std::vector<std::array<RodResultants, 2>> ends;  ///< at the ends of each; the force is that of the middle
};

/// Moments are carried from segment to segment, and zero at free ends and at ball joints. `model` has rods. Collective.
RodState state_of_rods(Model& model, const StepRecord& record);

}  // namespace pliant
