/// Places in bodies, as the input has them, on a mesh.
#pragma once

#include "energy/load/point_lines.hpp"
#include "input/config.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Where places are looked for.
struct BodiesOnMesh {
  const Config& config;  ///< with all rigid bodies
  const NodeLayout& layout;
  const std::vector<int>& body_of_cell;
  std::span<const char> is_left_out;  ///< local cells that are not of the mesh (cells_without_mesh)
};

/// What the points belong to, for messages.
struct PointsOf {
  std::string what;  ///< such as: spring 'pull'
  double length;     ///< a place in the mesh may lie outside of it by a thousandth of this [m]
};

/// The points in their order. Errors are added where a point lies outside the mesh or a body is not rigid; the points
/// are then of no use. Collective.
std::vector<AttachedPoint> attach(const BodiesOnMesh& bodies, std::span<const BodyPoint> points, const PointsOf& of,
                                  std::vector<Diagnostic>& errors);

/// Where the points are at displacements of the local nodes [m], the same on every rank. Collective.
std::vector<Vector3<double>> places_of(std::span<const AttachedPoint> points, const NodeLayout& layout,
                                       std::span<const double> u);
/// A field of the nodes at the points, their velocities for example; zero at points in space.
std::vector<Vector3<double>> field_at(std::span<const AttachedPoint> points, const NodeLayout& layout,
                                      std::span<const double> v);

}  // namespace pliant
