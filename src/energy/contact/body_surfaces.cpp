#include "energy/contact/body_surfaces.hpp"

#include "fem/facet_triangles.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <tuple>

namespace pliant {
namespace {

/// A segment is one triangle.
std::span<const std::array<int, 3>> triangles_of(std::span<const PetscInt> nodes) {
  return triangles_of_facet(is_segment(nodes) ? 3 : static_cast<int>(nodes.size()));
}

/// f(local nodes, facet) of each triangle of each facet.
template <class F>
void for_each_triangle(const FacetList& facets, const F& f) {
  const auto n = static_cast<std::size_t>(facets.nodes_per_facet);
  for (PetscInt facet = 0; facet < facets.size(); ++facet) {
    const auto nodes = std::span(facets.nodes).subspan(facet * n, n);
    for (const auto& [a, b, c] : triangles_of(nodes)) {
      f(std::array{nodes[a], nodes[b], nodes[c]}, facet);
    }
  }
}

/// The weights of a mid-edge node and of the two ends of its edge, for its vertex.
constexpr double middle_weight = 4.0 / 3.0, end_weight = -1.0 / 6.0;

Vector3<double> vertex_between(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& middle) {
  return middle_weight * middle + end_weight * (a + b);
}

/// f(node, one end, other end) of each mid-edge node of each facet.
template <class F>
void for_each_middle(const FacetList& facets, const F& f) {
  if (facets.nodes_per_facet != 6) return;
  for (std::size_t first = 0; first < facets.nodes.size(); first += 6) {
    const auto nodes = std::span(facets.nodes).subspan(first, 6);
    if (is_segment(nodes)) continue;
    f(nodes[3], nodes[0], nodes[1]);
    f(nodes[4], nodes[1], nodes[2]);
    f(nodes[5], nodes[0], nodes[2]);
  }
}

/// A mid-edge node and the ends of its edge.
struct Middle {
  VertexKey node = 0;
  std::array<VertexKey, 2> ends{};
};

/// Those of all ranks, by their keys. Collective.
std::vector<Middle> gathered_middles(const NodeLayout& layout, const FacetList& facets) {
  std::vector<Middle> middles;
  for_each_middle(facets, [&](PetscInt node, PetscInt a, PetscInt b) {
    if (node >= layout.num_owned_nodes) return;
    const auto [low, high] = std::minmax({VertexKey{layout.global_node(a)}, VertexKey{layout.global_node(b)}});
    middles.push_back({layout.global_node(node), {low, high}});
  });
  std::ranges::sort(middles, {}, &Middle::node);
  middles.erase(std::ranges::unique(middles, {}, &Middle::node).begin(), middles.end());
  middles = gathered(layout.comm, middles);
  std::ranges::sort(middles, {}, &Middle::node);
  return middles;
}

CollisionSurface gathered_surface(const NodeLayout& layout, const FacetList& facets, std::span<const FacetSide> sides,
                                  FacetVertices where) {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
  std::vector<char> is_listed(static_cast<std::size_t>(layout.num_owned_nodes), 0);
  const auto list = [&](PetscInt node, const Vector3<double>& X) {
    if (node >= layout.num_owned_nodes || is_listed[node] != 0) return;
    is_listed[node] = 1;
    vertices.push_back({layout.global_node(node), X});
  };
  for_each_middle(facets, [&](PetscInt node, PetscInt a, PetscInt b) {
    if (where == FacetVertices::nodes) return;
    list(node, vertex_between(layout.position(a), layout.position(b), layout.position(node)));
  });
  for (const PetscInt node : facets.nodes) list(node, layout.position(node));
  for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt facet) {
    if (!facets.is_owned[facet]) return;
    const auto key = [&](int k) { return VertexKey{layout.global_node(nodes[k])}; };
    const auto [body, set, thickness, rigid_part] = sides[facet];
    triangles.push_back({{key(0), key(1), key(2)}, body, set, thickness, rigid_part});
  });
  return CollisionSurface(gathered(layout.comm, vertices), gathered(layout.comm, triangles));
}

std::int32_t number_of(const CollisionSurface& surface, VertexKey key) {
  const auto place = std::ranges::lower_bound(surface.vertices(), key, {}, &CollisionSurface::Vertex::key);
  return static_cast<std::int32_t>(place - surface.vertices().begin());
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

std::vector<PetscInt> segment_as_facet(PetscInt a, PetscInt b, int nodes_per_facet) {
  std::vector<PetscInt> nodes(static_cast<std::size_t>(nodes_per_facet), b);
  nodes[0] = a;
  return nodes;
}

BodySurfaces::BodySurfaces(const NodeLayout& layout, const FacetList& facets, std::span<const FacetSide> sides,
                           FacetVertices vertices)
    : surface_(gathered_surface(layout, facets, sides, vertices)) {
  const auto triangles = surface_.triangles();
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
  if (facets.nodes_per_facet == 6 && vertices == FacetVertices::mean) {
    patches_.nodes_per_patch = 6;
    ends_.assign(surface_.vertices().size(), {-1, -1});
    for (const Middle& middle : gathered_middles(layout, facets)) {
      ends_[number_of(surface_, middle.node)] = {number_of(surface_, middle.ends[0]),
                                                 number_of(surface_, middle.ends[1])};
    }
  }
  list_nodes();
  list_patches(layout, facets);
}

void BodySurfaces::list_nodes() {
  for (const auto& triangle : surface_.triangles()) {
    const auto& own = triangle.vertices;
    nodes_of_triangles_.insert(nodes_of_triangles_.end(), own.begin(), own.end());
    if (ends_.empty()) continue;
    std::vector<std::int32_t> others;
    for (const std::int32_t vertex : own) {
      for (const std::int32_t end : ends_[vertex]) {
        if (end >= 0 && std::ranges::find(own, end) == own.end()) others.push_back(end);
      }
    }
    std::ranges::sort(others);
    others.erase(std::ranges::unique(others).begin(), others.end());
    others.resize(3, own[0]);
    nodes_of_triangles_.insert(nodes_of_triangles_.end(), others.begin(), others.end());
  }
}

void BodySurfaces::list_patches(const NodeLayout& layout, const FacetList& facets) {
  const auto triangles = surface_.triangles();
  const auto is_mine = [&](PetscInt node) { return node < layout.num_owned_nodes; };
  const auto nodes_per_facet = static_cast<std::size_t>(facets.nodes_per_facet);
  std::set<std::ptrdiff_t> segments;
  for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt facet) {
    const auto of_facet =
        std::span(facets.nodes).subspan(static_cast<std::size_t>(facet) * nodes_per_facet, nodes_per_facet);
    std::array<std::int32_t, 3> numbers{};
    for (std::size_t k = 0; k < 3; ++k) numbers[k] = number_of(surface_, layout.global_node(nodes[k]));
    numbers = in_lasting_order(numbers);
    const auto triangle = std::ranges::lower_bound(triangles, numbers, {}, &CollisionSurface::Triangle::vertices);
    const auto number = triangle - triangles.begin();
    if (triangle->is_segment() && !segments.insert(number).second) return;  // of two rods
    const std::size_t first = patches_.nodes.size();
    for (const std::int32_t vertex : nodes_of(static_cast<std::size_t>(number))) {
      const VertexKey key = surface_.vertices()[vertex].key;
      patches_.nodes.push_back(
          *std::ranges::find_if(of_facet, [&](PetscInt node) { return layout.global_node(node) == key; }));
    }
    const auto of_patch = std::span(patches_.nodes).subspan(first);
    if (std::ranges::none_of(of_patch, is_mine)) {
      patches_.nodes.resize(first);
      return;
    }
    patches_.keys.push_back(number);
    patches_.tags.push_back(surface_.triangles()[static_cast<std::size_t>(number)].group);
    // Not by the rank of the facet, which may have none of its nodes, and does not list it then.
    patches_.is_owned.push_back(is_mine(of_patch[0]));
    if (ends_.empty()) return;
    const auto of_triangle = nodes_of(static_cast<std::size_t>(number));
    for (const std::int32_t vertex : triangle->vertices) {
      const Support moves_with = support(vertex);
      PatchPoint point{.weights = moves_with.weights};
      for (int a = 0; a < moves_with.size; ++a) {
        const auto place = std::ranges::find(of_triangle, moves_with.nodes[a]) - of_triangle.begin();
        point.nodes[a] = static_cast<std::uint8_t>(place);
      }
      patches_.points.push_back(point);
    }
  });
  patches_.points_per_patch = ends_.empty() ? 0 : 3;
}

BodySurfaces::Support BodySurfaces::support(std::int32_t vertex) const {
  if (ends_.empty() || ends_[vertex][0] < 0) return {{vertex}, {1.0}, 1};
  const auto [a, b] = ends_[vertex];
  return {{vertex, a, b}, {middle_weight, end_weight, end_weight}, 3};
}

void BodySurfaces::place(std::int32_t vertex, std::span<Vector3<double>> x) const {
  const auto [a, b] = ends_[vertex];
  if (a >= 0) x[vertex] = vertex_between(x[a], x[b], x[vertex]);
}

void BodySurfaces::place(std::span<const std::int32_t> vertices, std::span<Vector3<double>> x) const {
  if (ends_.empty()) return;
  for (const std::int32_t vertex : vertices) place(vertex, x);
}

void BodySurfaces::place(std::span<Vector3<double>> x) const {
  for (std::size_t vertex = 0; vertex < ends_.size(); ++vertex) place(static_cast<std::int32_t>(vertex), x);
}

std::vector<Vector3<double>> gathered_nodes(const NodeLayout& layout, const BodySurfaces& surfaces,
                                            std::span<const double> q) {
  std::vector<Vector3<double>> mine;  // vertices are sorted by global numbers, which ascend with the ranks
  for (const auto& vertex : surfaces.surface().vertices()) {
    const VertexKey node = vertex.key - layout.first_global_node;
    if (node < 0 || node >= layout.num_owned_nodes) continue;
    const auto a = static_cast<PetscInt>(node);
    mine.push_back(layout.position(a) + Vector3<double>{q[3 * a], q[3 * a + 1], q[3 * a + 2]});
  }
  return gathered(layout.comm, mine);
}

std::vector<Vector3<double>> gathered_positions(const NodeLayout& layout, const BodySurfaces& surfaces,
                                                std::span<const double> q) {
  std::vector<Vector3<double>> x = gathered_nodes(layout, surfaces, q);
  surfaces.place(x);
  return x;
}

}  // namespace pliant
