#include "fem/layout.hpp"

#include "base/error.hpp"
#include "fem/element.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/plex.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

namespace pliant {
namespace {

/// Coordinates of all local vertices, xyz at 3 * (vertex - vertices.begin).
std::vector<double> vertex_coordinates(DM dm, PointRange vertices) {
  std::vector<double> x(3 * static_cast<std::size_t>(vertices.end - vertices.begin));
  Vec local = nullptr;
  PetscSection section = nullptr;
  check(DMGetCoordinatesLocal(dm, &local));
  check(DMGetCoordinateSection(dm, &section));
  if (x.empty()) return x;
  const ConstArrayView values(local);
  for (PetscInt v = vertices.begin; v < vertices.end; ++v) {
    PetscInt offset = 0;
    check(PetscSectionGetOffset(section, v, &offset));
    for (int k = 0; k < 3; ++k) x[3 * (v - vertices.begin) + k] = values[offset + k];
  }
  return x;
}

double signed_volume(const double* a, const double* b, const double* c, const double* d) {
  double e[3][3];
  for (int k = 0; k < 3; ++k) {
    e[0][k] = b[k] - a[k];
    e[1][k] = c[k] - a[k];
    e[2][k] = d[k] - a[k];
  }
  return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
         6.0;
}

/// The DMPlex points that carry a cell's nodes: four vertices, positively oriented, and for order 2 its six edges.
class CellClosure {
 public:
  CellClosure(DM dm, int order)
      : dm_(dm),
        order_(order),
        vertices_(stratum(dm, 0)),
        edges_(stratum(dm, 1)),
        x_(vertex_coordinates(dm, vertices_)) {}

  std::array<PetscInt, 10> operator()(PetscInt cell) const {
    std::array<PetscInt, 10> points;
    points.fill(-1);
    std::array<PetscInt, 6> edge_points;
    int num_vertices = 0, num_edges = 0;
    for_each_in_closure(dm_, cell, [&](PetscInt p) {
      if (vertices_.contains(p)) points[num_vertices++] = p;
      if (edges_.contains(p)) edge_points[num_edges++] = p;
    });
    if (signed_volume(at(points[0]), at(points[1]), at(points[2]), at(points[3])) < 0.0)
      std::swap(points[2], points[3]);
    if (order_ == 2) {
      for (int e = 0; e < 6; ++e) {
        points[4 + e] = joining_edge(dm_, edge_points, points[tet_edges[e][0]], points[tet_edges[e][1]]);
      }
    }
    return points;
  }

  std::array<double, 3> midpoint(PetscInt edge) const {
    const PetscInt* ends = ends_of_edge(dm_, edge);
    std::array<double, 3> m;
    for (int k = 0; k < 3; ++k) m[k] = 0.5 * (at(ends[0])[k] + at(ends[1])[k]);
    return m;
  }

  const double* at(PetscInt vertex) const { return x_.data() + 3 * (vertex - vertices_.begin); }
  bool is_vertex(PetscInt point) const { return vertices_.contains(point); }
  PetscInt edge_begin() const { return edges_.begin; }

 private:
  DM dm_;
  int order_;
  PointRange vertices_, edges_;
  std::vector<double> x_;
};

/// Reverse Cuthill-McKee order of the owned nodes: entry i is the old number of the node that becomes i.
std::vector<PetscInt> reverse_cuthill_mckee(const NodeGraph& graph, PetscInt num_nodes) {
  // MatGetOrdering needs a matrix; its rows must be sorted and lie within the owned block.
  std::vector<PetscInt> i(num_nodes + 1, 0), j;
  j.reserve(graph.neighbours.size());
  for (PetscInt n = 0; n < num_nodes; ++n) {
    for (PetscInt k = graph.offsets[n]; k < graph.offsets[n + 1]; ++k) {
      if (graph.neighbours[k] < num_nodes) j.push_back(graph.neighbours[k]);
    }
    std::sort(j.begin() + i[n], j.end());
    i[n + 1] = static_cast<PetscInt>(j.size());
  }
  std::vector<double> values(j.size(), 1.0);
  Handle<Mat> matrix;
  check(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, num_nodes, num_nodes, i.data(), j.data(), values.data(),
                                  matrix.out()));
  Handle<IS> rows, columns;
  check(MatGetOrdering(matrix.get(), MATORDERINGRCM, rows.out(), columns.out()));
  const PetscInt* order = nullptr;
  check(ISGetIndices(rows.get(), &order));
  std::vector<PetscInt> result(order, order + num_nodes);
  check(ISRestoreIndices(rows.get(), &order));
  return result;
}

/// Fills ghost entries of a per-point array with the owners' values.
void fill_ghosts(DM dm, std::vector<PetscInt>& per_point) {
  PetscSF sf = nullptr;
  check(DMGetPointSF(dm, &sf));
  PetscInt num_roots = 0;
  check(PetscSFGetGraph(sf, &num_roots, nullptr, nullptr, nullptr));
  if (num_roots < 0) return;  // one rank: no graph
  std::vector<PetscInt> owners = per_point;
  check(PetscSFBcastBegin(sf, MPIU_INT, owners.data(), per_point.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, MPIU_INT, owners.data(), per_point.data(), MPI_REPLACE));
}

bool is_straight(const std::array<double, 3>& a, const std::array<double, 3>& b, const std::array<double, 3>& mid) {
  double bend = 0.0, length = 0.0;
  for (int k = 0; k < 3; ++k) {
    bend += std::pow(mid[k] - 0.5 * (a[k] + b[k]), 2);
    length += std::pow(b[k] - a[k], 2);
  }
  return bend <= 1e-24 * length;
}

}  // namespace

NodeGraph node_graph(std::span<const PetscInt> cell_nodes, int nodes_per_cell, PetscInt num_nodes, PetscInt num_rows) {
  const auto num_cells = static_cast<PetscInt>(cell_nodes.size() / nodes_per_cell);
  std::vector<PetscInt> first(num_nodes + 1, 0);
  for (const PetscInt n : cell_nodes) ++first[n + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<PetscInt> cells_at(cell_nodes.size()), next(first.begin(), first.end() - 1);
  for (PetscInt c = 0; c < num_cells; ++c) {
    for (int a = 0; a < nodes_per_cell; ++a) cells_at[next[cell_nodes[c * nodes_per_cell + a]]++] = c;
  }
  NodeGraph graph;
  graph.offsets.reserve(num_rows + 1);
  graph.offsets.push_back(0);
  std::vector<PetscInt> seen_from(num_nodes, -1);
  for (PetscInt n = 0; n < num_rows; ++n) {
    for (PetscInt k = first[n]; k < first[n + 1]; ++k) {
      for (int a = 0; a < nodes_per_cell; ++a) {
        const PetscInt m = cell_nodes[cells_at[k] * nodes_per_cell + a];
        if (seen_from[m] == n) continue;
        seen_from[m] = n;
        graph.neighbours.push_back(m);
      }
    }
    graph.offsets.push_back(static_cast<PetscInt>(graph.neighbours.size()));
  }
  return graph;
}

NodeLayout make_layout(const Mesh& mesh, int order) {
  DM dm = mesh.dm.get();
  NodeLayout layout;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(dm), &layout.comm));
  layout.order = order;
  const int npc = layout.nodes_per_cell = order == 1 ? 4 : 10;
  const CellClosure closure(dm, order);

  const std::vector<char> is_ghost = ghost_points(dm);
  const auto num_points = static_cast<PetscInt>(is_ghost.size());

  // 1. The cells: owned ones, then ghost cells with an owned node.
  const PointRange cells = stratum(dm, 3);
  std::vector<PetscInt> points_of_cells;
  for (const bool ghosts : {false, true}) {
    for (PetscInt c = cells.begin; c < cells.end; ++c) {
      if ((is_ghost[c] != 0) != ghosts) continue;
      const auto points = closure(c);
      const auto owned = [&](PetscInt p) { return is_ghost[p] == 0; };
      if (ghosts && std::none_of(points.begin(), points.begin() + npc, owned)) continue;
      layout.cell_points.push_back(c);
      points_of_cells.insert(points_of_cells.end(), points.begin(), points.begin() + npc);
    }
    if (!ghosts) layout.num_owned_cells = static_cast<PetscInt>(layout.cell_points.size());
  }
  layout.num_local_cells = static_cast<PetscInt>(layout.cell_points.size());

  // 2. Provisional numbers in order of appearance, owned before ghosts; then the order that keeps neighbours close.
  std::vector<PetscInt> provisional(num_points, -1), points;
  for (const bool ghosts : {false, true}) {
    for (const PetscInt p : points_of_cells) {
      if (provisional[p] >= 0 || (is_ghost[p] != 0) != ghosts) continue;
      provisional[p] = static_cast<PetscInt>(points.size());
      points.push_back(p);
    }
    if (!ghosts) layout.num_owned_nodes = static_cast<PetscInt>(points.size());
  }
  layout.num_local_nodes = static_cast<PetscInt>(points.size());
  std::vector<PetscInt> cell_nodes(points_of_cells.size());
  std::transform(points_of_cells.begin(), points_of_cells.end(), cell_nodes.begin(),
                 [&](PetscInt p) { return provisional[p]; });
  const auto rcm = reverse_cuthill_mckee(node_graph(cell_nodes, npc, layout.num_local_nodes, layout.num_owned_nodes),
                                         layout.num_owned_nodes);

  // 3. Global numbers: contiguous per rank; ghosts receive theirs from the owners.
  check_mpi(MPI_Exscan(&layout.num_owned_nodes, &layout.first_global_node, 1, MPIU_INT, MPI_SUM, layout.comm));
  const PetscInt64 num_nodes = sum(layout.comm, static_cast<PetscInt64>(layout.num_owned_nodes));
  if (3 * num_nodes > static_cast<PetscInt64>(PETSC_MAX_INT)) {
    throw InputError(
        {}, "there are " + std::to_string(3 * num_nodes) +
                " unknowns, too many for 32-bit indices: build Pliant with a PETSc configured for 64-bit indices");
  }
  layout.num_global_nodes = static_cast<PetscInt>(num_nodes);
  const std::int64_t owned_cells = layout.num_owned_cells;
  check_mpi(MPI_Allreduce(&owned_cells, &layout.num_global_cells, 1, MPI_INT64_T, MPI_SUM, layout.comm));
  std::vector<PetscInt> global_of_point(num_points, -1);
  layout.node_of_point.assign(num_points, -1);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const PetscInt p = points[rcm[n]];
    layout.node_of_point[p] = n;
    global_of_point[p] = layout.first_global_node + n;
  }
  fill_ghosts(dm, global_of_point);
  std::vector<PetscInt> ghosts(points.begin() + layout.num_owned_nodes, points.end());
  std::sort(ghosts.begin(), ghosts.end(),
            [&](PetscInt p, PetscInt q) { return global_of_point[p] < global_of_point[q]; });
  for (const PetscInt p : ghosts) {
    layout.node_of_point[p] = layout.num_owned_nodes + static_cast<PetscInt>(layout.ghost_global_nodes.size());
    layout.ghost_global_nodes.push_back(global_of_point[p]);
  }

  // 4. Cells sorted by their nodes, owned and ghost cells separately.
  std::vector<PetscInt> cell_order(layout.num_local_cells), lowest(layout.num_local_cells);
  std::iota(cell_order.begin(), cell_order.end(), 0);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    PetscInt low = layout.num_local_nodes;
    for (int a = 0; a < 4; ++a) low = std::min(low, layout.node_of_point[points_of_cells[c * npc + a]]);
    lowest[c] = low;
  }
  const auto by_nodes = [&](PetscInt c, PetscInt d) { return lowest[c] < lowest[d]; };
  std::stable_sort(cell_order.begin(), cell_order.begin() + layout.num_owned_cells, by_nodes);
  std::stable_sort(cell_order.begin() + layout.num_owned_cells, cell_order.end(), by_nodes);
  layout.cell_nodes.resize(points_of_cells.size());
  std::vector<PetscInt> cell_points(layout.num_local_cells);
  for (PetscInt i = 0; i < layout.num_local_cells; ++i) {
    const PetscInt c = cell_order[i];
    cell_points[i] = layout.cell_points[c];
    for (int a = 0; a < npc; ++a) layout.cell_nodes[i * npc + a] = layout.node_of_point[points_of_cells[c * npc + a]];
  }
  layout.cell_points = std::move(cell_points);
  for (const PetscInt c : layout.cell_points) layout.cell_numbers.push_back(mesh.cell_numbers[c - cells.begin]);
  const PointRange vertices = stratum(dm, 0);
  layout.vertex_numbers.assign(static_cast<std::size_t>(layout.num_local_nodes), -1);
  for (PetscInt v = vertices.begin; v < vertices.end; ++v) {
    const PetscInt node = layout.node_of_point[v];
    if (node >= 0) layout.vertex_numbers[node] = mesh.vertex_numbers[v - vertices.begin];
  }

  // 5. Positions, and which cells are curved.
  layout.coordinates.resize(3 * static_cast<std::size_t>(layout.num_local_nodes));
  const bool curved = order == 2 && mesh.geometry_order == 2;
  for (const PetscInt p : points) {
    double* x = layout.coordinates.data() + 3 * layout.node_of_point[p];
    if (closure.is_vertex(p)) {
      std::copy_n(closure.at(p), 3, x);
    } else if (curved) {
      std::copy_n(mesh.edge_midpoints.data() + 3 * (p - closure.edge_begin()), 3, x);
    } else {
      std::copy_n(closure.midpoint(p).data(), 3, x);
    }
  }
  layout.cell_is_affine.assign(layout.num_local_cells, 1);
  if (curved) {
    for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
      const auto nodes = layout.nodes_of_cell(c);
      for (int e = 0; e < 6; ++e) {
        if (!is_straight(layout.position(nodes[tet_edges[e][0]]), layout.position(nodes[tet_edges[e][1]]),
                         layout.position(nodes[4 + e]))) {
          layout.cell_is_affine[c] = 0;
        }
      }
    }
  }
  return layout;
}

Handle<Vec> make_vector(const NodeLayout& layout) {
  Handle<Vec> v;
  check(VecCreateGhostBlock(layout.comm, 3, 3 * layout.num_owned_nodes, PETSC_DECIDE,
                            static_cast<PetscInt>(layout.ghost_global_nodes.size()), layout.ghost_global_nodes.data(),
                            v.out()));
  return v;
}

}  // namespace pliant
