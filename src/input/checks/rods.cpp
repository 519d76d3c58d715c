#include "input/checks/rods.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The volume of a rigid body of either kind, or `ground`.
std::vector<std::string> holders(const Config& config) {
  std::vector<std::string> names{"ground"};
  for (const BodyConfig& body : config.bodies) {
    if (body.is_rigid && !body.part.name.empty()) names.push_back(body.part.name);
  }
  for (const RigidBodyConfig& body : config.rigid_bodies) names.push_back(body.name);
  return names;
}

void check_holder(const Config& config, const RodConfig& rod, const Located<std::string>& holder,
                  Diagnostics& diagnostics) {
  if (holder.value.empty()) return;
  const std::vector<std::string> known = holders(config);
  if (std::ranges::find(known, holder.value) != known.end()) return;
  diagnostics.add(holder.where, fmt::format("rod '{}' is fixed in '{}', which is not a rigid body{}; there are: {}",
                                            rod.name, holder.value, did_you_mean(holder.value, known), joined(known)));
}

void check_section(const RodConfig& rod, Diagnostics& diagnostics) {
  if (!rod.section && !rod.radius) {
    diagnostics.add(
        {rod.where, {"radius"}}, rod.where,
        fmt::format("missing key 'radius' of rod '{}': its section is round unless 'section' says otherwise",
                    rod.name));
  }
  if (rod.section && rod.radius) {
    diagnostics.add(rod.where,
                    fmt::format("rod '{}' has a 'radius' and a rectangular 'section': remove one of them", rod.name));
  }
}

void check_rod(const Config& config, const RodConfig& rod, Diagnostics& diagnostics) {
  check_section(rod, diagnostics);
  check_holder(config, rod, rod.start, diagnostics);
  check_holder(config, rod, rod.end, diagnostics);
  for (std::size_t k = 1; k < rod.points.size(); ++k) {
    if (rod.points[k] != rod.points[k - 1]) continue;
    diagnostics.add(rod.where, fmt::format("rod '{}' has the same point twice in a row", rod.name));
  }
  const auto pulls = [&](const LoadConfig& load) {
    return std::holds_alternative<LoadConfig::Gravity>(load.kind) &&
           (load.part.kind == Selection::Kind::everything || load.part.name == rod.name);
  };
  const bool is_dynamic = analysis_of(config) == Analysis::dynamic;
  if (rod.density == 0.0 && (is_dynamic || std::ranges::any_of(config.loads, pulls))) {
    diagnostics.add({rod.where, {"density"}}, rod.where,
                    fmt::format("missing key 'density' of rod '{}', which {} needs", rod.name,
                                is_dynamic ? "dynamics" : "gravity"));
  }
  const bool has_line = !rod.curve.empty() || !rod.points.empty();  // else an error of its own
  if (rod.bends == false && has_line && (rod.curve.empty() || !rod.holder(0).empty() || !rod.holder(1).empty())) {
    diagnostics.add(
        {rod.where, {"bending"}}, rod.where,
        fmt::format("rod '{}' does not resist bending, so that it is held by nothing but a body along its "
                    "`curve`: {}, or remove 'bending: false'",
                    rod.name, rod.curve.empty() ? "give it one instead of `points`" : "remove `start` and `end`"));
  }
  if (!rod.curve.empty() && config.mesh.file.value.empty()) {
    diagnostics.add(rod.where, fmt::format("rod '{}' follows a curve of the mesh, which this input lacks: give its "
                                           "'points'",
                                           rod.name));
  }
}

}  // namespace

void check_rods(const Config& config, Diagnostics& diagnostics) {
  if (config.rods.empty()) return;
  for (const RodConfig& rod : config.rods) check_rod(config, rod, diagnostics);
  const Location& first = config.rods.front().where;
  if (config.mesh.refine > 0) {
    diagnostics.add(first, "rods cannot be refined with the mesh: remove 'refine', and mesh the bodies finer in gmsh");
  }
}

}  // namespace pliant
