#include "fem/selection.hpp"

#include "base/tensor.hpp"
#include "fem/element.hpp"
#include "petsc/plex.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// Local DMPlex points of the group, of its own dimension.
std::vector<PetscInt> points_of_group(const Mesh& mesh, const PhysicalGroup& group) {
  DM dm = mesh.dm.get();
  const PointRange wanted = stratum(dm, group.dimension);
  Handle<IS> is;
  check(DMGetStratumIS(dm, label_name(group).c_str(), 1, is.out()));
  std::vector<PetscInt> points;
  if (!is) return points;
  PetscInt size = 0;
  const PetscInt* indices = nullptr;
  check(ISGetLocalSize(is.get(), &size));
  check(ISGetIndices(is.get(), &indices));
  std::copy_if(indices, indices + size, std::back_inserter(points), [&](PetscInt p) { return wanted.contains(p); });
  check(ISRestoreIndices(is.get(), &indices));
  return points;
}

/// Collects facets; leaves out those with a node that is not in the layout, and those that neither are owned nor have
/// an owned node. (The nodes of an owned facet may all belong to other ranks.)
class FacetCollector {
 public:
  FacetCollector(const Mesh& mesh, const NodeLayout& layout)
      : dm_(mesh.dm.get()),
        layout_(layout),
        vertices_(stratum(dm_, 0)),
        edges_(stratum(dm_, 1)),
        is_ghost_(ghost_points(dm_)) {
    list_.nodes_per_facet = layout.order == 1 ? 3 : 6;
  }

  void add(PetscInt facet, const Region& inside) {
    std::array<PetscInt, 6> points;
    points.fill(-1);
    std::array<PetscInt, 3> edges{-1, -1, -1};
    int num_vertices = 0, num_edges = 0;
    for (const PetscInt p : Closure(dm_, facet)) {
      if (vertices_.contains(p)) points[num_vertices++] = p;
      if (edges_.contains(p)) edges[num_edges++] = p;
    }
    if (list_.nodes_per_facet == 6) {
      for (int e = 0; e < 3; ++e) {
        points[3 + e] = joining_edge(dm_, edges, points[triangle_edges[e][0]], points[triangle_edges[e][1]]);
      }
    }
    std::array<PetscInt, 6> nodes{};
    const bool is_owned = is_ghost_[facet] == 0;
    bool is_wanted = is_owned;
    for (int a = 0; a < list_.nodes_per_facet; ++a) {
      nodes[a] = layout_.node_of_point[points[a]];
      if (nodes[a] < 0 || !inside(layout_.position(nodes[a]))) return;
      is_wanted = is_wanted || nodes[a] < layout_.num_owned_nodes;
    }
    if (!is_wanted) return;
    const PetscInt* cells = nullptr;
    PetscInt num_cells = 0;
    check(DMPlexGetSupport(dm_, facet, &cells));
    check(DMPlexGetSupportSize(dm_, facet, &num_cells));
    const bool is_outer = num_cells == 1;
    if (is_outer && points_inward(cells[0], points, nodes)) {
      std::swap(nodes[1], nodes[2]);
      std::swap(nodes[3], nodes[5]);  // of the edges 01 and 02
    }
    list_.nodes.insert(list_.nodes.end(), nodes.begin(), nodes.begin() + list_.nodes_per_facet);
    list_.is_owned.push_back(is_owned);
    list_.is_outer.push_back(is_outer);
  }

  FacetList take() { return std::move(list_); }

 private:
  /// Whether the corners go clockwise seen from outside the cell that the facet (its points and nodes) belongs to.
  bool points_inward(PetscInt cell, const std::array<PetscInt, 6>& points, const std::array<PetscInt, 6>& nodes) const {
    const auto X0 = layout_.position(nodes[0]);
    Tensor3<double> edges{};  // to the facet's other corners, and to the cell's corner off the facet
    const auto set_row = [&](int row, PetscInt node) {
      const auto X = layout_.position(node);
      for (int i = 0; i < 3; ++i) edges(row, i) = X[i] - X0[i];
    };
    set_row(0, nodes[1]);
    set_row(1, nodes[2]);
    for (const PetscInt p : Closure(dm_, cell)) {
      const bool is_of_facet = std::find(points.begin(), points.begin() + 3, p) != points.begin() + 3;
      if (vertices_.contains(p) && !is_of_facet) set_row(2, layout_.node_of_point[p]);
    }
    return det(edges) > 0.0;
  }

  DM dm_;
  const NodeLayout& layout_;
  PointRange vertices_, edges_;
  std::vector<char> is_ghost_;
  FacetList list_;
};

bool everywhere(const std::array<double, 3>&) {
  return true;
}

}  // namespace

std::vector<PetscInt> nodes_of_group(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group) {
  std::vector<PetscInt> nodes;
  for (const PetscInt p : points_of_group(mesh, group)) {
    for (const PetscInt q : Closure(mesh.dm.get(), p)) {
      const PetscInt n = layout.node_of_point[q];
      if (n >= 0 && n < layout.num_owned_nodes) nodes.push_back(n);
    }
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<PetscInt> nodes_in_region(const NodeLayout& layout, const Region& inside) {
  std::vector<PetscInt> nodes;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    if (inside(layout.position(n))) nodes.push_back(n);
  }
  return nodes;
}

EdgeList edges_of_group(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group) {
  DM dm = mesh.dm.get();
  const std::vector<char> is_ghost = ghost_points(dm);
  EdgeList list;
  list.nodes_per_edge = layout.order + 1;
  for (const PetscInt edge : points_of_group(mesh, group)) {
    const PetscInt* ends = ends_of_edge(dm, edge);
    const std::array<PetscInt, 3> points{ends[0], ends[1], edge};
    std::array<PetscInt, 3> nodes{};
    bool is_here = true, is_wanted = is_ghost[edge] == 0;
    for (int a = 0; a < list.nodes_per_edge; ++a) {
      nodes[a] = layout.node_of_point[points[a]];
      is_here = is_here && nodes[a] >= 0;
      is_wanted = is_wanted || nodes[a] < layout.num_owned_nodes;
    }
    if (!is_here || !is_wanted) continue;
    list.nodes.insert(list.nodes.end(), nodes.begin(), nodes.begin() + list.nodes_per_edge);
    list.is_owned.push_back(is_ghost[edge] == 0);
  }
  return list;
}

FacetList facets_of_group(const Mesh& mesh, const NodeLayout& layout, const PhysicalGroup& group) {
  FacetCollector collector(mesh, layout);
  for (const PetscInt p : points_of_group(mesh, group)) collector.add(p, everywhere);
  return collector.take();
}

FacetList surface_facets(const Mesh& mesh, const NodeLayout& layout, const Region& inside) {
  // A facet that is owned or has an owned node has all its cells here, so one supporting cell means: on the surface.
  FacetCollector collector(mesh, layout);
  const PointRange facets = stratum(mesh.dm.get(), 2);
  for (PetscInt f = facets.begin; f < facets.end; ++f) {
    PetscInt num_cells = 0;
    check(DMPlexGetSupportSize(mesh.dm.get(), f, &num_cells));
    if (num_cells == 1) collector.add(f, inside);
  }
  return collector.take();
}

std::vector<int> volume_of_cells(const Mesh& mesh, const NodeLayout& layout,
                                 const std::vector<PhysicalGroup>& volumes) {
  const PointRange cells = stratum(mesh.dm.get(), 3);
  std::vector<int> of_point(cells.end - cells.begin, -1);
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    for (const PetscInt p : points_of_group(mesh, volumes[v])) {
      int& entry = of_point[p - cells.begin];
      entry = entry == -1 ? static_cast<int>(v) : -2;
    }
  }
  std::vector<int> result;
  for (const PetscInt p : layout.cell_points) result.push_back(of_point[p - cells.begin]);
  return result;
}

}  // namespace pliant
