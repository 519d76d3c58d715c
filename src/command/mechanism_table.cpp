#include "command/mechanism_table.hpp"

#include "base/text.hpp"
#include "input/elasticity.hpp"
#include "input/input.hpp"
#include "input/parse.hpp"
#include "mesh/report.hpp"
#include "model/rigid_bodies.hpp"
#include "model/selections.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Components that are zero but for rounding are written as 0.
std::string place(Vector3<double> x) {
  constexpr double rounding = 1e-12;
  const double size = norm(x);
  for (double& component : x) component = std::abs(component) > rounding * size ? component : 0.0;
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]);
}

std::string cells_of(const Model& model, std::size_t body) {
  double count = 0.0;
  for (PetscInt c = 0; c < model.layout().num_owned_cells; ++c) {
    count += model.body_of_cell()[static_cast<std::size_t>(c)] == static_cast<int>(body) ? 1.0 : 0.0;
  }
  return fmt::format("{:.0f} tetrahedra", sum(model.layout().comm, count));
}

/// The smallest box around places of all ranks.
class Extent {
 public:
  void add(const double* x) {
    for (std::size_t k = 0; k < 3; ++k) {
      bounds_[k] = std::min(bounds_[k], x[k]);
      bounds_[3 + k] = std::max(bounds_[3 + k], x[k]);
    }
  }
  /// A line of its own; none without places. Collective.
  void append_to(std::vector<std::string>& lines, MPI_Comm comm) const {
    std::array<double, 6> all{};
    for (std::size_t k = 0; k < 3; ++k) {
      all[k] = minimum(comm, bounds_[k]);
      all[3 + k] = maximum(comm, bounds_[3 + k]);
    }
    if (all[0] <= all[3]) lines.push_back("    extent " + extent_text(all));
  }

 private:
  static constexpr double far = std::numeric_limits<double>::max();
  std::array<double, 6> bounds_{far, far, far, -far, -far, -far};
};

Extent extent_of_body(const Model& model, std::size_t body) {
  const NodeLayout& layout = model.layout();
  Extent extent;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    if (model.body_of_cell()[static_cast<std::size_t>(c)] != static_cast<int>(body)) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) extent.add(&layout.coordinates[3 * static_cast<std::size_t>(n)]);
  }
  return extent;
}

/// Where a point of a tendon or a spring is fixed.
std::string holder(const BodyPoint& point) {
  return point.body.empty() ? "the mesh" : point.body;
}

/// The surfaces of other bodies that a rigid one holds; `Body`: a BodyConfig or a RigidBodyConfig.
template <class Body>
std::string holds(const Body& body) {
  const auto listed = [](const char* key, const std::vector<Located<std::string>>& surfaces) {
    std::vector<std::string> names;
    for (const auto& surface : surfaces) names.push_back(surface.value);
    return names.empty() ? std::string() : fmt::format(", {}: {}", key, joined(names));
  };
  return listed("attached", body.attached) + listed("coupled", body.coupled);
}

std::string line_of(const JointConfig& joint) {
  std::string text = fmt::format("  {}: {}, {} - {}, at {}", joint.name, name_of(joint.type), joint.between[0],
                                 joint.between[1], place(joint.point));
  if (joint.second_point) text += fmt::format(" and {}", place(*joint.second_point));
  if (joint.axis) text += fmt::format(", axis {}", place(unit(Vector3<double>(*joint.axis))));
  if (joint.second_axis) text += fmt::format(" and {}", place(unit(Vector3<double>(*joint.second_axis))));
  if (joint.motion) text += ", moved";
  if (joint.motor) text += ", motor";
  if (joint.bearing) text += fmt::format(", bearing with friction {:.6g}", joint.bearing->friction);
  if (joint.limits) text += fmt::format(", stops at {:.6g} and {:.6g}", (*joint.limits)[0], (*joint.limits)[1]);
  return text;
}

std::string line_of(const SpringConfig& spring, const LineSpring& on_mesh, double length) {
  std::string text = fmt::format("  {}: {} - {}, {:.6g} m long", spring.name, holder(spring.points[0]),
                                 holder(spring.points[1]), length);
  if (spring.stiffness > 0.0) text += fmt::format(", {:.6g} N/m from {:.6g} m on", spring.stiffness, on_mesh.rest);
  if (spring.is_tension_only) text += ", slack below";
  if (spring.damping > 0.0) text += fmt::format(", damping {:.6g} N s/m", spring.damping);
  return text;
}

/// What the forces on a rigid part decide, after a comma.
std::string freedom_of(const ConstraintConfig::Rigid& rigid) {
  std::vector<std::string> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!rigid.translation[i]) axes.emplace_back(1, "xyz"[i]);
  }
  std::string text = axes.empty() ? "" : ", moves freely along " + joined(axes);
  const auto* about = std::get_if<RotationConfig::AboutAxis>(&rigid.rotation.kind);
  if (std::holds_alternative<RotationConfig::Free>(rigid.rotation.kind)) text += ", turns freely";
  if (about != nullptr && !about->angle) text += ", turns freely about " + place(about->axis);
  return text;
}

}  // namespace

std::vector<std::string> body_table(const Config& config, const Model& model) {
  std::vector<std::string> lines{"bodies"};
  const Config completed = with_rigid_bodies(config);
  Diagnostics ignored;
  const InputNode input = parse_yaml(dump(config), config.file, ignored);
  const InputNode* bodies = given(input, {"bodies"});
  for (std::size_t b = 0; b < config.bodies.size(); ++b) {
    const BodyConfig& body = config.bodies[b];
    std::string text = fmt::format("  {}: {}, {}", model.body_names()[b], cells_of(model, b),
                                   body.elasticity ? describe(*body.elasticity) : "rigid");
    if (body.density) text += fmt::format(", density {:.4g} kg/m^3", *body.density);
    if (body.is_rigid) {
      const auto [mass, center] =
          mass_of_rigid_body(completed, model.layout(), model.body_of_cell(), model.shells(), static_cast<int>(b));
      if (mass > 0.0) text += fmt::format(", mass {:.6g} kg", mass);
      text += ", center " + place(center) + holds(body);
    }
    lines.push_back(std::move(text));
    extent_of_body(model, b).append_to(lines, model.layout().comm);
    if (bodies == nullptr || b >= bodies->children.size()) continue;
    for (const char* key : {"viscosity", "active", "expansion", "mullins"}) {
      if (const InputNode* more = bodies->children[b].find(key)) {
        lines.push_back(fmt::format("    {}: {}", key, flow_text(*more)));
      }
    }
  }
  for (std::size_t r = 0; r < config.rigid_bodies.size(); ++r) {
    const RigidBodyConfig& body = config.rigid_bodies[r];
    const std::string shape = body.surface ? cells_of(model, config.bodies.size() + r) + ", " : "";
    lines.push_back(fmt::format("  {}: {}rigid, mass {:.6g} kg, center {}{}", body.name, shape, body.mass,
                                place(body.center), holds(body)));
    if (body.surface) extent_of_body(model, config.bodies.size() + r).append_to(lines, model.layout().comm);
  }
  return lines.size() > 1 ? lines : std::vector<std::string>{};
}

std::vector<std::string> rod_table(const Config& config, const Model& model) {
  std::vector<std::string> lines;
  const std::vector<double> at_rest(3 * static_cast<std::size_t>(model.layout().num_local_nodes), 0.0);
  const auto& rods = model.rods().rods;
  if (!rods.empty()) lines.emplace_back("rods");
  for (std::size_t r = 0; r < rods.size(); ++r) {
    const RodConfig& rod = config.rods[r];
    const RodSection section = section_of(rod);
    const double E = rod.youngs_modulus, G = E / (2.0 * (1.0 + rod.poissons_ratio));
    std::string text =
        fmt::format("  {}: {} segments, {:.6g} m long", rod.name, rods[r].num_segments(), rods[r].length);
    if (rod.density > 0.0) text += fmt::format(", mass {:.6g} kg", rod.density * section.area * rods[r].length);
    text += fmt::format("; stiffness: E A {:.6g} N, E I {:.6g}", E * section.area, E * section.second_moments[0]);
    if (rod.section) text += fmt::format(" and {:.6g}", E * section.second_moments[1]);
    text += fmt::format(" N m^2, G J {:.6g} N m^2", G * section.torsion);
    if (rods[r].is_fibre) text += "; a fibre: only E A counts";
    for (std::size_t end = 0; end < 2; ++end) {
      const std::string& holder = rod.holder(end);
      if (!holder.empty()) text += fmt::format(", {} fixed in {}", end == 0 ? "start" : "end", holder);
    }
    lines.push_back(std::move(text));
    Extent extent;
    for (const Vector3<double>& x : places_of(rods[r].points, model.layout(), at_rest)) extent.add(x.data());
    extent.append_to(lines, model.layout().comm);
  }
  return lines;
}

std::vector<std::string> shell_table(const Config& config, const Model& model) {
  std::vector<std::string> lines;
  if (!config.shells.empty()) lines.emplace_back("shells");
  for (std::size_t k = 0; k < config.shells.size(); ++k) {
    const ShellConfig& shell = config.shells[k];
    const ModelShell& on_mesh = model.shells().shells[k];
    std::string text = fmt::format("  {}: {} facets, {:.6g} m^2, thickness {:.6g} m, {}", shell.name,
                                   on_mesh.num_facets, on_mesh.area, shell.thickness, describe(shell.elasticity));
    if (on_mesh.mass_per_area > 0.0) text += fmt::format(", mass {:.6g} kg", on_mesh.mass_per_area * on_mesh.area);
    if (!shell.prestretch.empty()) {
      text += fmt::format(", stretched by {:.6g}", shell.prestretch.front());
      if (shell.prestretch.size() == 2) text += fmt::format(" and {:.6g}", shell.prestretch.back());
    }
    if (shell.bends) text += ", bends";
    lines.push_back(std::move(text));
    Extent extent;
    for (const PetscInt n : on_mesh.facets.nodes) {
      extent.add(&model.layout().coordinates[3 * static_cast<std::size_t>(n)]);
    }
    extent.append_to(lines, model.layout().comm);
  }
  return lines;
}

std::vector<std::string> rigid_part_table(const Config& config, const Model& model) {
  std::vector<std::string> lines;
  for (std::size_t c = 0; c < config.constraints.size(); ++c) {
    const auto* rigid = std::get_if<ConstraintConfig::Rigid>(&config.constraints[c].kind);
    if (rigid == nullptr) continue;
    if (lines.empty()) lines.emplace_back("rigid parts");
    const ConstraintPart& part = model.constraints().parts()[c];
    const auto count = sum(model.layout().comm, static_cast<PetscInt64>(part.nodes.size()));
    const std::string& name = config.constraints[c].name;
    lines.push_back(fmt::format("  {}{}: {} nodes, center {}{}{}", name.empty() ? "" : name + ", ",
                                describe(config.constraints[c].part), count, place(part.displacement.rigid->centre),
                                rigid->center ? "" : " by default", freedom_of(*rigid)));
  }
  return lines;
}

std::vector<std::string> mechanism_table(const Config& config, const Model& model) {
  std::vector<std::string> lines;
  if (!config.joints.empty()) lines.emplace_back("joints");
  for (const JointConfig& joint : config.joints) lines.push_back(line_of(joint));
  const ModelSprings& springs = model.springs();
  if (!springs.names.empty()) lines.emplace_back("springs");
  const std::vector<double> at_rest(3 * static_cast<std::size_t>(model.layout().num_local_nodes), 0.0);
  const auto ends = places_of(springs.points, model.layout(), at_rest);
  for (std::size_t k = 0; k < springs.names.size(); ++k) {
    lines.push_back(line_of(config.springs[k], springs.springs[k], norm(ends[2 * k + 1] - ends[2 * k])));
  }
  if (!model.tendons().empty()) lines.emplace_back("tendons");
  for (const ModelTendon& tendon : model.tendons()) {
    lines.push_back(fmt::format("  {}: {} points, {:.6g} m long, turns by {:.4g} rad", tendon.name,
                                tendon.points.size(), tendon.length, tendon.turn));
  }
  return lines;
}

}  // namespace pliant
