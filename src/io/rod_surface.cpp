#include "io/rod_surface.hpp"

#include "base/vector3.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace pliant {
namespace {

using Nodes = std::array<std::int64_t, 4>;

/// Sides of a round section.
constexpr int sides_of_circle = 16;

Vector3<double> place(const OutputMesh& mesh, std::int64_t node) {
  const double* x = &mesh.coordinates[3 * static_cast<std::size_t>(node)];
  return {x[0], x[1], x[2]};
}

/// How far x_0, x_1, p_1, p_2 are from a segment: p_1 - m, p_2 - m and x_1 - x_0 are at right angles there, m the
/// middle of x_0 and x_1.
double error_of(const std::array<Vector3<double>, 4>& x) {
  const Vector3<double> along = unit(x[1] - x[0]), middle = 0.5 * (x[0] + x[1]), d1 = unit(x[2] - middle),
                        d2 = unit(x[3] - middle);
  return std::abs(dot(along, d1)) + std::abs(dot(along, d2)) + std::abs(dot(d1, d2));
}

/// The corners of a segment's cell in the order x_0, x_1, p_1, p_2; that of the two pairs is arbitrary. Where two
/// orders fit, the axis is the longest.
Nodes ordered(const OutputMesh& mesh, const std::int64_t* cell) {
  constexpr std::array<std::array<std::size_t, 4>, 6> orders{
      {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}}};
  constexpr double rounding = 1e-6;
  Nodes best{};
  double least = std::numeric_limits<double>::infinity(), longest = 0.0;
  for (const auto& order : orders) {
    Nodes nodes{};
    std::array<Vector3<double>, 4> x;
    for (std::size_t k = 0; k < 4; ++k) {
      nodes[k] = cell[order[k]];
      x[k] = place(mesh, nodes[k]);
    }
    const double error = error_of(x), length = norm(x[1] - x[0]);
    const bool is_as_good = error < least + rounding && length > longest;
    if (!(error < least - rounding || is_as_good)) continue;
    best = nodes;
    least = error;
    longest = length;
  }
  return best;
}

/// Points around a section, in units of the directors.
std::vector<std::array<double, 2>> outline(const OutputMesh& mesh, const std::string& name) {
  if (std::ranges::find(mesh.rectangular_rods, name) != mesh.rectangular_rods.end()) {
    return {{1.0, 1.0}, {-1.0, 1.0}, {-1.0, -1.0}, {1.0, -1.0}};
  }
  std::vector<std::array<double, 2>> points;
  for (int k = 0; k < sides_of_circle; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / sides_of_circle;
    points.push_back({std::cos(angle), std::sin(angle)});
  }
  return points;
}

/// Adds two ends and a mantle; each with vertices of its own, so that their edges are sharp.
class Prism {
 public:
  Prism(const Nodes& nodes, int body, bool is_turned, BodySurface& surface)
      : nodes_(nodes), body_(body), is_turned_(is_turned), surface_(surface) {}

  void add(const std::vector<std::array<double, 2>>& outline) {
    const auto n = static_cast<std::int32_t>(outline.size());
    const bool has_edges = n == 4;
    for (std::int32_t k = 0; k < n; ++k) {
      const auto& a = outline[static_cast<std::size_t>(k)];
      const auto& b = outline[static_cast<std::size_t>((k + 1) % n)];
      if (has_edges || k == 0) first_ = next();
      if (has_edges) {
        for (const auto& [point, end] : {std::pair{a, 0}, {b, 0}, {b, 1}, {a, 1}}) vertex(point, end);
        quad(0, 1, 2, 3);
      }
    }
    if (!has_edges) {
      for (const auto& point : outline) {
        vertex(point, 0);
        vertex(point, 1);
      }
      for (std::int32_t k = 0; k < n; ++k) quad(2 * k, 2 * ((k + 1) % n), 2 * ((k + 1) % n) + 1, 2 * k + 1);
    }
    for (const int end : {0, 1}) {
      first_ = next();
      for (const auto& point : outline) vertex(point, end);
      for (std::int32_t k = 2; k < n; ++k) end == 0 ? triangle(0, k, k - 1) : triangle(0, k - 1, k);
    }
  }

 private:
  std::int32_t next() const { return static_cast<std::int32_t>(surface_.num_vertices()); }
  void vertex(const std::array<double, 2>& point, int end) {
    const double half = 0.5 * (point[0] + point[1]);
    BodySurface::Blend blend{nodes_, {-half, -half, point[0], point[1]}};
    blend.weights[static_cast<std::size_t>(end)] += 1.0;
    surface_.blends.push_back(blend);
    surface_.nodes.push_back(nodes_[static_cast<std::size_t>(end)]);
    surface_.bodies.push_back(body_);
  }
  void triangle(std::int32_t a, std::int32_t b, std::int32_t c) {
    if (is_turned_) std::swap(b, c);
    surface_.triangles.insert(surface_.triangles.end(), {first_ + a, first_ + b, first_ + c});
  }
  void quad(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    triangle(a, b, c);
    triangle(a, c, d);
  }

  Nodes nodes_;
  int body_;
  bool is_turned_;  // the frame is left-handed
  BodySurface& surface_;
  std::int32_t first_ = 0;
};

}  // namespace

void add_prisms(const OutputMesh& mesh, BodySurface& surface) {
  for (std::size_t c = 0; c < mesh.bodies.size(); ++c) {
    const std::string& name = mesh.body_names[static_cast<std::size_t>(mesh.bodies[c])];
    if (std::ranges::find(mesh.rods, name) == mesh.rods.end()) continue;
    const Nodes nodes = ordered(mesh, &mesh.cells[c * static_cast<std::size_t>(mesh.nodes_per_cell)]);
    const auto x = [&](std::size_t k) { return place(mesh, nodes[k]); };
    const Vector3<double> middle = 0.5 * (x(0) + x(1));
    const bool is_turned = dot(x(1) - x(0), cross(x(2) - middle, x(3) - middle)) < 0.0;
    Prism(nodes, mesh.bodies[c], is_turned, surface).add(outline(mesh, name));
  }
}

}  // namespace pliant
