#include "io/body_surface.hpp"

#include "base/error.hpp"
#include "base/vector3.hpp"
#include "io/rod_surface.hpp"
#include "io/unit_sphere.hpp"
#include "mesh/disjoint_sets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace pliant {
namespace {

/// Facets of a tetrahedron in VTK's order of nodes: corners seen from outside counterclockwise, then the nodes in the
/// middle of the edges 01, 12, 20.
constexpr std::array<std::array<int, 6>, 4> facets{
    {{0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {2, 0, 3, 6, 7, 9}, {0, 2, 1, 6, 5, 4}}};
/// A facet with six nodes as four triangles; the first three have a corner of the facet first.
constexpr std::array<std::array<int, 3>, 4> quarters{{{0, 3, 5}, {1, 4, 3}, {2, 5, 4}, {3, 4, 5}}};
constexpr double sharp = 0.82;  // cosine of the smallest angle between normals at a sharp edge, 35 degrees

/// Divisions of ellipsoids, where there are few and where there are many.
constexpr int fine = 3, coarse = 1;
constexpr std::size_t few_ellipsoids = 60;

using Node = std::int32_t;

/// Which bodies are among those of these names.
std::vector<char> are_among(const std::vector<std::string>& names, const OutputMesh& mesh) {
  std::vector<char> result;
  for (const auto& name : mesh.body_names) result.push_back(std::ranges::find(names, name) != names.end() ? 1 : 0);
  return result;
}

struct Facet {
  std::array<Node, 3> corners;  // ascending
  int body;
  std::int64_t place;  // 4 cell + facet of the cell

  auto key() const { return std::tie(corners, body); }
};

Vector3<double> position(const OutputMesh& mesh, Node node) {
  const double* x = &mesh.coordinates[3 * static_cast<std::size_t>(node)];
  return {x[0], x[1], x[2]};
}

/// Number of cells at each node; empty for a mesh without shells.
std::vector<int> cells_at_nodes(const OutputMesh& mesh) {
  if (mesh.shells.empty()) return {};
  std::vector<int> number(static_cast<std::size_t>(mesh.global_num_nodes), 0);
  for (const std::int64_t node : mesh.cells) ++number[static_cast<std::size_t>(node)];
  return number;
}

/// The apex among the corners of a shell's cell: it belongs to no other cell, and is nearest to the middle.
int apex_of(const OutputMesh& mesh, const std::int64_t* nodes, const std::vector<int>& cells_at) {
  std::array<Vector3<double>, 4> x;
  for (std::size_t k = 0; k < 4; ++k) x[k] = position(mesh, static_cast<Node>(nodes[k]));
  const Vector3<double> sum = x[0] + x[1] + x[2] + x[3];
  std::array<double, 4> distance;
  for (std::size_t k = 0; k < 4; ++k) {
    const bool is_shared = cells_at[static_cast<std::size_t>(nodes[k])] > 1;
    distance[k] = is_shared ? std::numeric_limits<double>::infinity() : norm(4.0 * x[k] - sum);
  }
  return static_cast<int>(std::ranges::min_element(distance) - distance.begin());
}

/// Facets that belong to one cell of their body, by cell; of shells their triangles.
std::vector<Facet> outer_facets(const OutputMesh& mesh) {
  std::vector<Facet> all;
  all.reserve(4 * mesh.bodies.size());
  const std::vector<char> is_mass = are_among(mesh.masses, mesh), is_rod = are_among(mesh.rods, mesh),
                          is_section = are_among(mesh.sections, mesh), is_shell = are_among(mesh.shells, mesh);
  const std::vector<int> cells_at = cells_at_nodes(mesh);
  for (std::size_t c = 0; c < mesh.bodies.size(); ++c) {
    const auto body = static_cast<std::size_t>(mesh.bodies[c]);
    if (is_mass[body] != 0 || is_rod[body] != 0 || is_section[body] != 0) continue;
    const std::int64_t* nodes = &mesh.cells[c * static_cast<std::size_t>(mesh.nodes_per_cell)];
    const int apex = is_shell[body] != 0 ? apex_of(mesh, nodes, cells_at) : -1;
    for (int f = 0; f < 4; ++f) {
      if (apex == facets[f][0] || apex == facets[f][1] || apex == facets[f][2]) continue;
      Facet facet{{}, mesh.bodies[c], 4 * static_cast<std::int64_t>(c) + f};
      for (int i = 0; i < 3; ++i) facet.corners[i] = static_cast<Node>(nodes[facets[f][i]]);
      std::ranges::sort(facet.corners);
      all.push_back(facet);
    }
  }
  std::ranges::sort(all, [](const Facet& a, const Facet& b) { return a.key() < b.key(); });
  std::vector<Facet> outer;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t next = i + 1;
    while (next < all.size() && all[next].key() == all[i].key()) ++next;
    if (next == i + 1) outer.push_back(all[i]);
    i = next;
  }
  std::ranges::sort(outer, {}, &Facet::place);
  return outer;
}

/// Nodes of triangles, three each, and the body of each triangle.
struct SurfaceTriangles {
  std::vector<Node> nodes;
  std::vector<int> bodies;
  int per_facet = 1;
};

SurfaceTriangles triangles_of(const OutputMesh& mesh, std::size_t most_divided) {
  const auto outer = outer_facets(mesh);
  SurfaceTriangles triangles;
  triangles.per_facet = mesh.nodes_per_cell == 10 && outer.size() <= most_divided ? 4 : 1;
  for (const Facet& facet : outer) {
    const std::int64_t* nodes = &mesh.cells[static_cast<std::size_t>(facet.place / 4 * mesh.nodes_per_cell)];
    const auto& of_facet = facets[static_cast<std::size_t>(facet.place % 4)];
    for (int t = 0; t < triangles.per_facet; ++t) {
      for (int i = 0; i < 3; ++i) {
        triangles.nodes.push_back(static_cast<Node>(nodes[of_facet[triangles.per_facet == 4 ? quarters[t][i] : i]]));
      }
      triangles.bodies.push_back(facet.body);
    }
  }
  return triangles;
}

/// Unit normals; zero for a triangle without area.
std::vector<Vector3<double>> normals_of(const OutputMesh& mesh, const SurfaceTriangles& triangles) {
  std::vector<Vector3<double>> normals;
  for (std::size_t t = 0; t < triangles.bodies.size(); ++t) {
    const Node* n = &triangles.nodes[3 * t];
    const auto a = position(mesh, n[0]);
    const auto normal = cross(position(mesh, n[1]) - a, position(mesh, n[2]) - a);
    normals.push_back(norm(normal) > 0.0 ? unit(normal) : normal);
  }
  return normals;
}

/// Side i of triangle t goes from its corner i to the next.
struct Side {
  Node low, high;
  int body;
  std::size_t low_corner, high_corner;  // corners are counted through all triangles: 3 t + i

  auto key() const { return std::tie(low, high, body); }
};

/// Corners of triangles that form one vertex: those connected across sides that are not sharp.
DisjointSets joined_corners(const OutputMesh& mesh, const SurfaceTriangles& triangles) {
  const auto normals = normals_of(mesh, triangles);
  std::vector<Side> sides;
  sides.reserve(triangles.nodes.size());
  for (std::size_t corner = 0; corner < triangles.nodes.size(); ++corner) {
    const std::size_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
    Side side{triangles.nodes[corner], triangles.nodes[next], triangles.bodies[corner / 3], corner, next};
    if (side.low > side.high) {
      std::swap(side.low, side.high);
      std::swap(side.low_corner, side.high_corner);
    }
    sides.push_back(side);
  }
  std::ranges::sort(sides, [](const Side& a, const Side& b) { return a.key() < b.key(); });
  DisjointSets sets(triangles.nodes.size());
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t next = i + 1;
    while (next < sides.size() && sides[next].key() == sides[i].key()) ++next;
    if (next == i + 2) {
      const Side &a = sides[i], &b = sides[i + 1];
      if (dot(normals[a.low_corner / 3], normals[b.low_corner / 3]) > sharp) {
        sets.join(a.low_corner, b.low_corner);
        sets.join(a.high_corner, b.high_corner);
      }
    }
    i = next;
  }
  return sets;
}

/// The lowest 21 bits of `x` with two zeros after each one.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

/// Positions of nodes along Morton's curve: neighbours in space are close on it.
class MortonCurve {
 public:
  explicit MortonCurve(const OutputMesh& mesh) : mesh_(mesh) {
    low_.fill(std::numeric_limits<double>::infinity());
    double size = 0.0;
    for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) low_[i % 3] = std::min(low_[i % 3], mesh.coordinates[i]);
    for (std::size_t i = 0; i < mesh.coordinates.size(); ++i) size = std::max(size, mesh.coordinates[i] - low_[i % 3]);
    scale_ = size > 0.0 ? 2097151.0 / size : 0.0;
  }

  std::uint64_t operator()(Node node) const {
    const auto x = position(mesh_, node);
    std::uint64_t code = 0;
    for (std::size_t i = 0; i < 3; ++i) code |= spread(static_cast<std::uint64_t>((x[i] - low_[i]) * scale_)) << i;
    return code;
  }

 private:
  const OutputMesh& mesh_;
  Vector3<double> low_;
  double scale_ = 0.0;
};

double volume_of_cell(const OutputMesh& mesh, std::size_t cell) {
  const std::int64_t* n = &mesh.cells[cell * static_cast<std::size_t>(mesh.nodes_per_cell)];
  const auto x = [&](int i) { return position(mesh, static_cast<Node>(n[i])); };
  return std::abs(dot(cross(x(1) - x(0), x(2) - x(0)), x(3) - x(0))) / 6.0;
}

BodySurface::Averages averages_of(const OutputMesh& mesh, const BodySurface& surface) {
  // Vertices at a node: a list, threaded through the vertices.
  constexpr std::int32_t none = -1;
  std::vector<std::int32_t> first_at(mesh.coordinates.size() / 3, none), next(surface.num_vertices(), none);
  for (std::size_t v = 0; v < surface.num_vertices(); ++v) {
    next[v] = std::exchange(first_at[static_cast<std::size_t>(surface.nodes[v])], static_cast<std::int32_t>(v));
  }
  const auto visit = [&](auto&& body) {
    for (std::size_t c = 0; c < mesh.bodies.size(); ++c) {
      for (int i = 0; i < mesh.nodes_per_cell; ++i) {
        const auto node = mesh.cells[c * static_cast<std::size_t>(mesh.nodes_per_cell) + static_cast<std::size_t>(i)];
        for (std::int32_t v = first_at[static_cast<std::size_t>(node)]; v != none; v = next[v]) {
          if (surface.bodies[v] == mesh.bodies[c]) body(static_cast<std::size_t>(v), c);
        }
      }
    }
  };
  BodySurface::Averages averages;
  averages.first.assign(surface.num_vertices() + 1, 0);
  visit([&](std::size_t v, std::size_t) { ++averages.first[v + 1]; });
  std::partial_sum(averages.first.begin(), averages.first.end(), averages.first.begin());
  averages.cells.resize(averages.first.back());
  averages.weights.resize(averages.first.back());
  std::vector<std::size_t> end(averages.first.begin(), averages.first.end() - 1);
  std::vector<double> total(surface.num_vertices(), 0.0);
  visit([&](std::size_t v, std::size_t c) {
    averages.cells[end[v]] = static_cast<std::int64_t>(c);
    total[v] += averages.weights[end[v]++] = std::max(volume_of_cell(mesh, c), std::numeric_limits<double>::min());
  });
  for (std::size_t v = 0; v < surface.num_vertices(); ++v) {
    for (std::size_t k = averages.first[v]; k < averages.first[v + 1]; ++k) averages.weights[k] /= total[v];
  }
  return averages;
}

/// The corners of the tetrahedra that stand for masses, by body: those that belong to one cell.
std::map<int, std::array<Node, 4>> corners_of_masses(const OutputMesh& mesh) {
  const std::vector<char> is_mass = are_among(mesh.masses, mesh);
  std::map<int, std::map<Node, int>> num_cells;
  for (std::size_t c = 0; c < mesh.bodies.size(); ++c) {
    if (is_mass[static_cast<std::size_t>(mesh.bodies[c])] == 0) continue;
    const std::int64_t* nodes = &mesh.cells[c * static_cast<std::size_t>(mesh.nodes_per_cell)];
    for (int i = 0; i < 4; ++i) ++num_cells[mesh.bodies[c]][static_cast<Node>(nodes[i])];
  }
  std::map<int, std::array<Node, 4>> result;
  for (const auto& [body, nodes] : num_cells) {
    std::vector<Node> corners;
    for (const auto& [node, count] : nodes) {
      if (count == 1) corners.push_back(node);
    }
    if (corners.size() != 4)
      throw FileError("the body '" + mesh.body_names[static_cast<std::size_t>(body)] +
                      "' of the result is damaged: it is not a tetrahedron");
    std::ranges::copy(corners, result[body].begin());
  }
  return result;
}

/// Adds the ellipsoids of bodies that are only masses.
void add_ellipsoids(const OutputMesh& mesh, BodySurface& surface) {
  constexpr std::array<Vector3<double>, 4> corners{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
  const Sphere sphere = unit_sphere(mesh.masses.size() > few_ellipsoids ? coarse : fine);
  for (const auto& [body, nodes] : corners_of_masses(mesh)) {
    BodySurface::Blend blend{};
    std::ranges::copy(nodes, blend.nodes.begin());
    const auto first = static_cast<std::int32_t>(surface.num_vertices());
    for (const Vector3<double>& x : sphere.points) {
      for (std::size_t k = 0; k < 4; ++k) blend.weights[k] = 0.25 * (1.0 + dot(corners[k], x));
      surface.blends.push_back(blend);
      surface.nodes.push_back(nodes[0]);
      surface.bodies.push_back(body);
    }
    // The corners above have a negative volume; where the nodes have a positive one, their order is mirrored.
    const auto x = position(mesh, nodes[0]);
    const double volume =
        dot(cross(position(mesh, nodes[1]) - x, position(mesh, nodes[2]) - x), position(mesh, nodes[3]) - x);
    for (auto [i, j, k] : sphere.triangles) {
      if (volume > 0.0) std::swap(j, k);
      surface.triangles.insert(surface.triangles.end(), {first + i, first + j, first + k});
    }
  }
}

}  // namespace

BodySurface surface_of_bodies(const OutputMesh& mesh, std::size_t most_divided) {
  if (mesh.global_num_nodes > std::numeric_limits<Node>::max()) {
    throw FileError("cannot draw the mesh: it has more than 2^31 nodes");
  }
  const SurfaceTriangles triangles = triangles_of(mesh, most_divided);
  DisjointSets sets = joined_corners(mesh, triangles);
  std::vector<std::size_t> roots;
  for (std::size_t corner = 0; corner < triangles.nodes.size(); ++corner) {
    if (sets.root(corner) == corner) roots.push_back(corner);
  }
  const MortonCurve place(mesh);
  std::ranges::stable_sort(roots, {}, [&](std::size_t root) { return place(triangles.nodes[root]); });

  BodySurface surface;
  surface.triangles_per_facet = triangles.per_facet;
  std::vector<std::int32_t> vertex_of_root(triangles.nodes.size());
  for (const std::size_t root : roots) {
    vertex_of_root[root] = static_cast<std::int32_t>(surface.num_vertices());
    surface.nodes.push_back(triangles.nodes[root]);
    surface.bodies.push_back(triangles.bodies[root / 3]);
  }
  for (std::size_t corner = 0; corner < triangles.nodes.size(); ++corner) {
    surface.triangles.push_back(vertex_of_root[sets.root(corner)]);
  }
  if (!mesh.masses.empty()) add_ellipsoids(mesh, surface);
  add_prisms(mesh, surface);
  surface.averages = averages_of(mesh, surface);
  return surface;
}

std::vector<double> at_vertices(const BodySurface& surface, std::span<const double> values, FieldLocation location,
                                int components) {
  const auto n = static_cast<std::size_t>(components);
  std::vector<double> result(n * surface.num_vertices(), 0.0);
  const std::size_t first_blend = surface.num_vertices() - surface.blends.size();
  for (std::size_t v = 0; v < surface.num_vertices(); ++v) {
    if (location == FieldLocation::node && v >= first_blend) {
      const auto& [nodes, weights] = surface.blends[v - first_blend];
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        const double* of_node = &values[n * static_cast<std::size_t>(nodes[k])];
        for (std::size_t i = 0; i < n; ++i) result[n * v + i] += weights[k] * of_node[i];
      }
      continue;
    }
    if (location == FieldLocation::node) {
      std::copy_n(&values[n * static_cast<std::size_t>(surface.nodes[v])], n, &result[n * v]);
      continue;
    }
    for (std::size_t k = surface.averages.first[v]; k < surface.averages.first[v + 1]; ++k) {
      const double* of_cell = &values[n * static_cast<std::size_t>(surface.averages.cells[k])];
      for (std::size_t i = 0; i < n; ++i) result[n * v + i] += surface.averages.weights[k] * of_cell[i];
    }
  }
  return result;
}

}  // namespace pliant
