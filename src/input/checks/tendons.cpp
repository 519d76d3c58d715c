#include "input/checks/tendons.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {
namespace {

void check_tendon(const TendonConfig& tendon, Diagnostics& diagnostics) {
  const auto is_on_ground = [](const BodyPoint& point) { return point.body == "ground"; };
  for (std::size_t k = 0; k < tendon.points.size(); ++k) {
    const BodyPoint& point = tendon.points[k];
    if (k > 0 && point.point == tendon.points[k - 1].point) {
      diagnostics.add(point.where, fmt::format("tendon '{}' has the same point twice in a row", tendon.name));
    }
  }
  if (tendon.tension && !tendon.tension->depends_on_time() && (*tendon.tension)(0.0, 0.0, 0.0, 0.0) < 0.0) {
    diagnostics.add(tendon.where, fmt::format("the tension of tendon '{}' is negative, and a string does not push; to "
                                              "pull at the other end, reverse the order of its points",
                                              tendon.name));
  }
  if (tendon.points.size() > 1 && std::ranges::all_of(tendon.points, is_on_ground)) {
    diagnostics.add(tendon.where,
                    fmt::format("all points of tendon '{}' are on the ground: it moves nothing", tendon.name));
    return;
  }
  const auto is_with_first = [&](const BodyPoint& point) { return point.body == tendon.points.front().body; };
  if (tendon.points.size() > 1 && !tendon.points.front().body.empty() &&
      std::ranges::all_of(tendon.points, is_with_first)) {
    diagnostics.add(tendon.where, fmt::format("all points of tendon '{}' are fixed in '{}': it moves nothing; lead it "
                                              "to another body or to the ground",
                                              tendon.name, tendon.points.front().body));
  }
}

}  // namespace

void check_tendons(const Config& config, Diagnostics& diagnostics) {
  for (const TendonConfig& tendon : config.tendons) check_tendon(tendon, diagnostics);
}

}  // namespace pliant
