#include "energy/contact/body_surfaces.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace pliant {
namespace {

/// The corners of the triangles of a facet, among its nodes (corners, then mid-edge nodes 01 12 02).
constexpr std::array<std::array<int, 3>, 1> linear_triangles{{{0, 1, 2}}};
constexpr std::array<std::array<int, 3>, 4> quadratic_triangles{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};

std::span<const std::array<int, 3>> triangles_of_facet(int nodes_per_facet) {
  if (nodes_per_facet == 3) return linear_triangles;
  return quadratic_triangles;
}

/// f(local nodes, facet) of each triangle of each facet.
template <class F>
void for_each_triangle(const FacetList& facets, const F& f) {
  const auto n = static_cast<std::size_t>(facets.nodes_per_facet);
  for (PetscInt facet = 0; facet < facets.size(); ++facet) {
    const auto nodes = std::span(facets.nodes).subspan(facet * n, n);
    for (const auto& [a, b, c] : triangles_of_facet(facets.nodes_per_facet)) {
      f(std::array{nodes[a], nodes[b], nodes[c]}, facet);
    }
  }
}

CollisionSurface gathered_surface(const NodeLayout& layout, const FacetList& facets, std::span<const FacetSide> sides) {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
  std::vector<char> is_listed(static_cast<std::size_t>(layout.num_owned_nodes), 0);
  for (const PetscInt node : facets.nodes) {
    if (node >= layout.num_owned_nodes || is_listed[node] != 0) continue;
    is_listed[node] = 1;
    vertices.push_back({layout.global_node(node), layout.position(node)});
  }
  for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt facet) {
    if (!facets.is_owned[facet]) return;
    const auto key = [&](int k) { return VertexKey{layout.global_node(nodes[k])}; };
    triangles.push_back({{key(0), key(1), key(2)}, sides[facet].body, sides[facet].set});
  });
  return CollisionSurface(gathered(layout.comm, vertices), gathered(layout.comm, triangles));
}

/// For each part of the triangles (three each) whether its triangle is the first of its set that has it.
std::vector<char> first_of_sets(std::span<const CollisionSurface::Triangle> triangles,
                                std::array<std::int32_t, 3> CollisionSurface::Triangle::*parts) {
  std::vector<std::tuple<std::int32_t, std::int32_t, std::size_t>> all;  // part, set, place
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) all.emplace_back((triangles[t].*parts)[k], triangles[t].group, 3 * t + k);
  }
  std::ranges::sort(all);
  std::vector<char> is_first(all.size(), 0);
  for (std::size_t n = 0; n < all.size(); ++n) {
    const auto& [part, set, place] = all[n];
    is_first[place] = n == 0 || std::get<0>(all[n - 1]) != part || std::get<1>(all[n - 1]) != set ? 1 : 0;
  }
  return is_first;
}

}  // namespace

BodySurfaces::BodySurfaces(const NodeLayout& layout, const FacetList& facets, std::span<const FacetSide> sides)
    : surface_(gathered_surface(layout, facets, sides)) {
  const auto triangles = surface_.triangles();
  const auto vertices = surface_.vertices();
  using Triangle = CollisionSurface::Triangle;
  const auto of_vertices = first_of_sets(triangles, &Triangle::vertices);
  const auto of_edges = first_of_sets(triangles, &Triangle::edges);
  stands_for_.resize(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      stands_for_[t] |= static_cast<std::uint8_t>(of_vertices[3 * t + k] << k | of_edges[3 * t + k] << (3 + k));
    }
  }
  patches_.nodes_per_patch = 3;
  for_each_triangle(facets, [&](std::array<PetscInt, 3> nodes, PetscInt facet) {
    const auto is_mine = [&](PetscInt node) { return node < layout.num_owned_nodes; };
    if (std::ranges::none_of(nodes, is_mine)) return;
    std::array<std::int32_t, 3> numbers{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = std::ranges::lower_bound(vertices, VertexKey{layout.global_node(nodes[k])}, {},
                                                  &CollisionSurface::Vertex::key);
      numbers[k] = static_cast<std::int32_t>(place - vertices.begin());
    }
    const auto first = std::ranges::min_element(numbers) - numbers.begin();
    std::ranges::rotate(numbers, numbers.begin() + first);
    std::ranges::rotate(nodes, nodes.begin() + first);
    const auto place = std::ranges::lower_bound(triangles, numbers, {}, &Triangle::vertices);
    patches_.nodes.insert(patches_.nodes.end(), nodes.begin(), nodes.end());
    patches_.keys.push_back(place - triangles.begin());
    patches_.tags.push_back(sides[facet].set);
    // Not by the rank of the facet, which may have none of its nodes, and does not list it then.
    patches_.is_owned.push_back(is_mine(nodes[0]));
  });
}

}  // namespace pliant
