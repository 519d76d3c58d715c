#include "input/checks/rigid_bodies.hpp"

#include "base/tensor.hpp"
#include "base/vector3.hpp"
#include "input/analysis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Relative to the largest moment: what rounding of the input may violate.
constexpr double rounding = 1e-6;

/// Every principal second moment, (the sum of the two other moments of inertia - its own) / 2, is positive or zero: the
/// principal minors of tr(J)/2 I - J, slightly enlarged, are.
bool has_real_mass(const std::array<double, 6>& moments) {
  const auto& [xx, yy, zz, xy, yz, zx] = moments;
  const double half = 0.5 * (xx + yy + zz), slack = rounding * std::abs(half);
  const double a = half - xx + slack, b = half - yy + slack, c = half - zz + slack;
  return a >= 0.0 && b >= 0.0 && c >= 0.0 && a * b >= xy * xy && b * c >= yz * yz && a * c >= zx * zx &&
         a * b * c - 2.0 * xy * yz * zx - a * yz * yz - b * zx * zx - c * xy * xy >= 0.0;
}

void check_limits(const JointConfig& joint, Diagnostics& diagnostics) {
  const auto& [low, high] = *joint.limits;
  if (!(low < high)) {
    diagnostics.add(joint.where, fmt::format("the limits of joint '{}' are [{:g}, {:g}]: the first must be smaller",
                                             joint.name, low, high));
  } else if (low > 0.0 || high < 0.0) {
    diagnostics.add(joint.where, fmt::format("joint '{}' is at 0 at the start, outside of its limits [{:g}, {:g}]",
                                             joint.name, low, high));
  }
}

/// What the keys of a joint cannot say one by one.
void check_joint(const JointConfig& joint, Diagnostics& diagnostics) {
  if (joint.type == JointType::distance && joint.second_point == joint.point) {
    diagnostics.add(
        joint.where,
        fmt::format("the points of joint '{}' are one: a distance of 0 is a joint of type 'ball'", joint.name));
  }
  if (joint.limits) check_limits(joint, diagnostics);
  if (joint.bearing && joint.type == JointType::hinge && !joint.bearing->radius) {
    diagnostics.add(joint.where,
                    fmt::format("the bearing of joint '{}' needs the radius of its pin: friction in a hinge "
                                "is a torque, coefficient times radius times load; add 'radius'",
                                joint.name));
  }
}

/// What the keys of a spring cannot say one by one.
void check_spring(const SpringConfig& spring, Diagnostics& diagnostics) {
  const auto& [first, second] = spring.points;
  if (spring.stiffness == 0.0 && spring.damping == 0.0) {
    diagnostics.add(spring.where,
                    fmt::format("spring '{}' does nothing: give it 'stiffness', 'damping' or both", spring.name));
  }
  if (spring.is_tension_only && spring.damping > 0.0) {
    diagnostics.add(spring.where, fmt::format("the damping of spring '{}' would jump where the spring becomes slack "
                                              "('tension_only'): make the damper an entry of its own",
                                              spring.name));
  }
  if (!first.body.empty() && first.body == second.body) {
    diagnostics.add(spring.where, fmt::format("both points of spring '{}' are fixed in '{}', so it does nothing: "
                                              "connect two bodies, or one and the ground",
                                              spring.name, first.body));
  }
}

/// `take(name, what, where)` notes a name, or reports that it has been taken.
template <class Take>
void take_rods(const Config& config, const Take& take, Diagnostics& diagnostics) {
  for (const RodConfig& rod : config.rods) {
    take(rod.name, "rod", rod.where);
    take(rod.name + "_start", "section of a rod", rod.where);
    take(rod.name + "_end", "section of a rod", rod.where);
    const auto has_name = [&](const BodyConfig& body) { return !body.is_rigid && body.part.name == rod.name; };
    if (std::ranges::any_of(config.bodies, has_name)) {
      diagnostics.add(rod.where,
                      fmt::format("'{}' is also the volume of a body with a mesh; rename the rod", rod.name));
    }
  }
}

}  // namespace

void check_rigid_bodies(const Config& config, Diagnostics& diagnostics) {
  std::map<std::string, std::string> taken;  // name: what has it
  const auto take = [&](const std::string& name, const char* what, const Location& where) {
    if (name.empty()) return;
    const auto [found, is_new] = taken.try_emplace(name, what);
    if (is_new) return;
    diagnostics.add(
        where, found->second == what
                   ? fmt::format("the {} name '{}' is given twice", what, name)
                   : fmt::format("'{}' names a {} and a {}, and history.csv has columns for both; rename one", name,
                                 found->second, what));
  };
  const auto refuse_ground = [&](const std::string& name, const Location& where) {
    if (name != "ground") return;
    diagnostics.add(where, "'ground' names what does not move; choose another name for the rigid body");
  };
  for (const BodyConfig& body : config.bodies) {
    if (!body.is_rigid) continue;
    take(body.part.name.empty() ? "body" : body.part.name, "rigid body", body.where);
    refuse_ground(body.part.name, body.where);
  }
  for (const RigidBodyConfig& body : config.rigid_bodies) {
    take(body.name, "rigid body", body.where);
    refuse_ground(body.name, body.where);
    const auto has_name = [&](const BodyConfig& other) { return !other.is_rigid && other.part.name == body.name; };
    if (std::ranges::any_of(config.bodies, has_name)) {
      diagnostics.add(body.where,
                      fmt::format("'{}' is also the volume of a body with a mesh; rename the rigid body", body.name));
    }
    const auto holds_end = [&](const RodConfig& rod) {
      return rod.start.value == body.name || rod.end.value == body.name;
    };
    const bool is_alone = body.attached.empty() && body.coupled.empty() && std::ranges::none_of(config.rods, holds_end);
    if (body.mass == 0.0 && (is_alone || std::ranges::max(body.inertia.moments) > 0.0)) {
      diagnostics.add(
          body.where,
          fmt::format("rigid body '{}' has no mass; only a point of reference has none, to which "
                      "a surface of another body is 'attached' or 'coupled', or in which a rod is fixed, and no "
                      "moments of inertia",
                      body.name));
    }
    if (!has_real_mass(body.inertia.moments)) {
      diagnostics.add(
          body.inertia.where,
          fmt::format("no body has these moments of inertia ('{}'): none of the principal ones is negative or "
                      "larger than the sum of the two others; they are about the center of mass, in kg m^2",
                      body.name));
    }
  }
  const bool none_has_surface =
      std::ranges::none_of(config.rigid_bodies, [](const RigidBodyConfig& body) { return body.surface.has_value(); });
  const bool are_alone = config.bodies.empty() && config.rods.empty() && config.shells.empty();
  if (config.contact && are_alone && !config.rigid_bodies.empty() && none_has_surface) {
    diagnostics.add(
        config.contact->where,
        "these rigid bodies have no surface that could touch anything: give them a 'surface', or mesh their volumes "
        "and list them in 'bodies' with 'rigid: true'");
  }
  for (const JointConfig& joint : config.joints) {
    take(joint.name, "joint", joint.where);
    check_joint(joint, diagnostics);
  }
  for (const TendonConfig& tendon : config.tendons) {
    take(tendon.name, "tendon", tendon.where);
  }
  for (const SpringConfig& spring : config.springs) {
    take(spring.name, "spring", spring.where);
    check_spring(spring, diagnostics);
  }
  take_rods(config, take, diagnostics);
  for (const ProbeConfig& probe : config.probes) {
    const auto found = taken.find(probe.name);
    if (found == taken.end()) continue;
    diagnostics.add(probe.where,
                    fmt::format("'{}' names a {} and a probe, and history.csv has columns for both; rename one",
                                probe.name, found->second));
  }
}

}  // namespace pliant
