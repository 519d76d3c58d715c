#include "input/checks/tendons.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace pliant {
namespace {

std::vector<std::string> names_of_rigid_bodies(const Config& config) {
  std::vector<std::string> names;
  for (const BodyConfig& body : config.bodies) {
    if (body.is_rigid) names.push_back(body.part.name.empty() ? "body" : body.part.name);
  }
  for (const RigidBodyConfig& body : config.rigid_bodies) names.push_back(body.name);
  return names;
}

void check_points(const TendonConfig& tendon, const std::vector<std::string>& rigid, Diagnostics& diagnostics) {
  using Point = TendonConfig::Point;
  const auto is_on_ground = [](const Point& point) { return point.body == "ground"; };
  for (std::size_t k = 0; k < tendon.points.size(); ++k) {
    const Point& point = tendon.points[k];
    if (k > 0 && point.place == tendon.points[k - 1].place) {
      diagnostics.add(point.where, fmt::format("tendon '{}' has the same point twice in a row", tendon.name));
    }
    if (point.body.empty() || is_on_ground(point) || std::ranges::find(rigid, point.body) != rigid.end()) continue;
    diagnostics.add(point.where, fmt::format("point {} of tendon '{}' is fixed in '{}', which is not a rigid body; "
                                             "{}for a point in a soft body give its coordinates only",
                                             k, tendon.name, point.body,
                                             rigid.empty() ? std::string()
                                                           : fmt::format("rigid are: {}; ", fmt::join(rigid, ", "))));
  }
  if (tendon.points.size() > 1 && std::ranges::all_of(tendon.points, is_on_ground)) {
    diagnostics.add(tendon.where,
                    fmt::format("all points of tendon '{}' are on the ground: it moves nothing", tendon.name));
  }
}

}  // namespace

void check_tendons(const Config& config, Diagnostics& diagnostics) {
  const std::vector<std::string> rigid = names_of_rigid_bodies(config);
  for (const TendonConfig& tendon : config.tendons) check_points(tendon, rigid, diagnostics);
}

}  // namespace pliant
