#include "model/joints_at_start.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"
#include "model/initial_displacement.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::size_t most_listed = 3;

/// The joints with what each forbids, the most first.
class Forbidden {
 public:
  Forbidden(const Config& config, const char* unit) : config_(config), unit_(unit) {}
  void add(std::size_t joint, double amount) {
    if (amount > 0.0) found_.emplace_back(amount, joint);
  }
  bool empty() const { return found_.empty(); }
  /// The place of the joint that forbids the most.
  const Location& where() const { return config_.joints[std::ranges::max(found_).second].where; }
  std::string listed() {
    std::ranges::stable_sort(found_, std::ranges::greater{}, [](const auto& one) { return one.first; });
    std::vector<std::string> names;
    for (const auto& [amount, joint] : found_) {
      if (names.size() == most_listed) break;
      const auto& [first, second] = config_.joints[joint].between;
      names.push_back(
          fmt::format("'{}' of {} and {} by {:.3g} {}", config_.joints[joint].name, first, second, amount, unit_));
    }
    std::string text = joined(names);
    if (found_.size() > most_listed) text += fmt::format(" and {} others", found_.size() - most_listed);
    return text;
  }

 private:
  const Config& config_;
  const char* unit_;
  std::vector<std::pair<double, std::size_t>> found_;
};

void require_motion_from_start(const Config& config, const JointConfig& joint) {
  constexpr double rounding = 1e-9;  // [rad] or [m]
  if (!joint.motion || analysis_of(config) != Analysis::dynamic) return;
  const double start = (*joint.motion)(0.0, 0.0, 0.0, 0.0);
  if (std::abs(start) <= rounding) return;
  throw InputError(joint.where,
                   fmt::format("the motion of joint '{}' begins at {:g}, and the bodies at 0: it must be 0 "
                               "at t = 0",
                               joint.name, start));
}

}  // namespace

std::vector<Diagnostic> warnings_about_joints_at_start(const Config& config, const NodeLayout& layout,
                                                       const std::vector<int>& body_of_cell,
                                                       std::span<const ModelJoint> joints) {
  for (const JointConfig& joint : config.joints) require_motion_from_start(config, joint);
  std::vector<Diagnostic> warnings;
  if (joints.empty() || analysis_of(config) == Analysis::static_equilibrium) return warnings;
  const Handle<Vec> q = make_vector(layout), v = make_vector(layout);
  put_initial_state(config, layout, body_of_cell, q.get(), v.get());
  Forbidden places(config, "m"), velocities(config, "m/s");
  std::map<const Mechanism*, std::vector<Mechanism::Violation>> of_mechanisms;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    auto& found = of_mechanisms[joints[j].mechanism];
    if (found.empty()) found = joints[j].mechanism->violations({0.0, config.time.step}, q.get(), v.get());
    const auto& [distance, speed] = found[joints[j].number];
    places.add(j, distance);
    velocities.add(j, speed);
  }
  if (!places.empty()) {
    warnings.push_back({Severity::warning, places.where(),
                        fmt::format("`initial.displacement` moves bodies as their joints forbid: {}; the run starts "
                                    "from the nearest configuration that the joints allow",
                                    places.listed())});
  }
  if (!velocities.empty() && analysis_of(config) == Analysis::dynamic) {
    warnings.push_back({Severity::warning, velocities.where(),
                        fmt::format("joints forbid the velocities at the start: {}; the run starts with the nearest "
                                    "ones that they allow; give each body `velocity` and `angular_velocity` that agree "
                                    "with its joints (velocity = angular_velocity x arm where it turns about a fixed "
                                    "point)",
                                    velocities.listed())});
  }
  return warnings;
}

}  // namespace pliant
