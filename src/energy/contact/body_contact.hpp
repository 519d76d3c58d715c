/// Contact of bodies with one another and with themselves: terms of pairs of surface triangles.
#pragma once

#include "energy/contact/touching_bodies.hpp"
#include "energy/term.hpp"

#include <memory>
#include <vector>

namespace pliant {

/// EnergyTerm::is_measured_at, a flag for each owned node: one side of the contact. nullptr: both, whose forces cancel.
using MeasuredNodes = std::shared_ptr<const std::vector<char>>;

/// The potential of collision/contact_pairs over the surfaces as they are deformed, with barriers.
///
/// Bodies start apart and stay so: no Newton step moves a vertex through a triangle or an edge through an edge
/// (`max_step`), and pressures grow without bound as gaps close. Derivatives are exact; the energy has two continuous
/// ones but where a closest point passes from a feature to its neighbour at an angle, where it has one.
std::unique_ptr<EnergyTerm> make_body_contact(std::shared_ptr<const TouchingBodies> bodies,
                                              MeasuredNodes measured = nullptr);

/// The term of a drag between bodies (Friction, NormalDamping) with the potential R of their relative velocity:
///
///     Phi = dt sum_touches A R(p, n; v),   v = sum w_i (q_i - q0_i) / dt
///
/// Pressure p, normal n and weights w are frozen as those of an obstacle's drag (make_friction), so that forces act
/// where they were frozen and balance exactly. For friction p includes the damping of the same bodies.
std::unique_ptr<EnergyTerm> make_body_friction(std::shared_ptr<const TouchingBodies> bodies, const Friction& friction,
                                               const NormalDamping& damping, FrictionUpdate update,
                                               MeasuredNodes measured = nullptr);
std::unique_ptr<EnergyTerm> make_body_damping(std::shared_ptr<const TouchingBodies> bodies,
                                              const NormalDamping& damping, FrictionUpdate update,
                                              MeasuredNodes measured = nullptr);

}  // namespace pliant
