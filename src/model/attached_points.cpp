#include "model/attached_points.hpp"

#include "base/text.hpp"
#include "energy/rigid/joint_effort.hpp"
#include "fem/straight_cell.hpp"
#include "model/shells.hpp"
#include "petsc/collective.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {
namespace {

/// How far outside the mesh a place may lie, relative to PointsOf::length: rounding, and curved surfaces.
constexpr double outside_of_mesh = 1e-3;

std::string name_of_body(const BodyConfig& body) {
  return body.part.name.empty() ? "body" : body.part.name;
}

bool moves_rigidly(const Config& config, const BodyConfig& body) {
  return body.is_rigid || std::ranges::any_of(config.constraints, [&](const ConstraintConfig& constraint) {
           return std::holds_alternative<ConstraintConfig::Rigid>(constraint.kind) &&
                  constraint.part.kind == body.part.kind && constraint.part.name == body.part.name;
         });
}

class Attachment {
 public:
  Attachment(const BodiesOnMesh& bodies, const PointsOf& of, std::vector<Diagnostic>& errors)
      : bodies_(bodies), of_(of), errors_(errors) {}

  /// In the cell that holds it.
  ProbeLocation in_mesh(const BodyPoint& point, const ProbeLocation& located) {
    const auto& [x, y, z] = point.point;
    if (bodies_.config.mesh.file.value.empty() && bodies_.config.rods.empty()) {
      refuse(point, fmt::format("{} has a point at ({:g}, {:g}, {:g}) in the mesh, and there is no mesh: name its "
                                "body, as in {{body: {}, point: [{:g}, {:g}, {:g}]}}",
                                of_.what, x, y, z, known_bodies().front(), x, y, z));
      return {};
    }
    if (located.distance == 0.0) return located;
    const NearestOfMesh nearest = nearest_of_mesh(bodies_.layout, point.point, bodies_.is_left_out);
    if (nearest.distance <= outside_of_mesh * of_.length) {
      auto at_nearest = locate(bodies_.layout, std::span(&nearest.point, 1), bodies_.is_left_out);
      move_to_triangles(bodies_.config, bodies_.layout, bodies_.body_of_cell, at_nearest);
      return at_nearest.front();
    }
    refuse(point, fmt::format("{} has a point at ({:g}, {:g}, {:g}), {:.3g} m outside the mesh; name its body if it is "
                              "fixed in a rigid one or to the ground: {{body: ground, point: [{:g}, {:g}, {:g}]}}",
                              of_.what, x, y, z, nearest.distance, x, y, z));
    return {};
  }

  /// In a rigid body: its motion is that of the corners of any of its cells, extended to all of space.
  ProbeLocation in_body(const BodyPoint& point) {
    const auto& all = bodies_.config.bodies;
    const auto found = std::ranges::find_if(all, [&](const BodyConfig& body) {
      return name_of_body(body) == point.body && moves_rigidly(bodies_.config, body);
    });
    if (found == all.end()) {
      const auto is_soft = [&](const BodyConfig& body) { return name_of_body(body) == point.body; };
      const auto known = known_bodies();
      refuse(point, fmt::format("{} has a point in '{}', which is not a rigid body{}; there are: {}{}", of_.what,
                                point.body, did_you_mean(point.body, known), joined(known),
                                std::ranges::any_of(all, is_soft)
                                    ? "; give a point of a soft body as a place in the mesh, [x, y, z]"
                                    : ""));
      return {};
    }
    const JointBody body = joint_body(bodies_.layout, bodies_.body_of_cell, static_cast<int>(found - all.begin()));
    if (!body.is_owned) return {};
    std::array<Vector3<double>, 4> corners;
    for (std::size_t a = 0; a < 4; ++a) corners[a] = bodies_.layout.position(body.nodes[a]);
    const auto gradients = linear_gradients(corners);
    ProbeLocation location;
    location.nodes = body.nodes;
    for (std::size_t a = 0; a < 4; ++a) {
      const Vector3<double> arm = Vector3<double>(point.point) - corners[0];
      location.weights.push_back((a == 0 ? 1.0 : 0.0) + dot(gradients[a], arm));
    }
    return location;
  }

 private:
  void refuse(const BodyPoint& point, std::string message) {
    errors_.push_back({Severity::error, point.where, std::move(message)});
  }
  std::vector<std::string> known_bodies() const {
    std::vector<std::string> known;
    for (const BodyConfig& body : bodies_.config.bodies) {
      if (moves_rigidly(bodies_.config, body)) known.push_back(name_of_body(body));
    }
    known.emplace_back("ground");
    return known;
  }

  const BodiesOnMesh& bodies_;
  const PointsOf& of_;
  std::vector<Diagnostic>& errors_;
};

/// The field at the points, by their numbers; that of points in space is zero.
std::vector<Vector3<double>> values_at(std::span<const AttachedPoint> points, MPI_Comm comm,
                                       std::span<const double> field) {
  std::vector<double> flat;
  for (const AttachedPoint& point : points) {
    for (const double component : point.location.interpolate(field)) flat.push_back(component);
  }
  sum_in_place(comm, flat);
  std::vector<Vector3<double>> values;
  for (std::size_t k = 0; k < flat.size(); k += 3) values.push_back({flat[k], flat[k + 1], flat[k + 2]});
  return values;
}

}  // namespace

std::vector<AttachedPoint> attach(const BodiesOnMesh& bodies, std::span<const BodyPoint> points, const PointsOf& of,
                                  std::vector<Diagnostic>& errors) {
  std::vector<std::array<double, 3>> in_mesh;
  for (const BodyPoint& point : points) {
    if (point.body.empty()) in_mesh.push_back(point.point);
  }
  auto located = in_mesh.empty() ? std::vector<ProbeLocation>{} : locate(bodies.layout, in_mesh, bodies.is_left_out);
  move_to_triangles(bodies.config, bodies.layout, bodies.body_of_cell, located);
  Attachment attachment(bodies, of, errors);
  std::vector<AttachedPoint> result;
  auto next = located.begin();
  for (const BodyPoint& point : points) {
    if (point.body == "ground") {
      result.push_back({{}, Vector3<double>(point.point)});
    } else if (point.body.empty()) {
      result.push_back({attachment.in_mesh(point, *next++), {}});
    } else {
      result.push_back({attachment.in_body(point), {}});
    }
  }
  return result;
}

std::vector<Vector3<double>> places_of(std::span<const AttachedPoint> points, const NodeLayout& layout,
                                       std::span<const double> u) {
  auto places = values_at(points, layout.comm, layout.coordinates);
  const auto d = values_at(points, layout.comm, u);
  for (std::size_t k = 0; k < points.size(); ++k) places[k] = points[k].fixed ? *points[k].fixed : places[k] + d[k];
  return places;
}

std::vector<Vector3<double>> field_at(std::span<const AttachedPoint> points, const NodeLayout& layout,
                                      std::span<const double> v) {
  return values_at(points, layout.comm, v);
}

}  // namespace pliant
