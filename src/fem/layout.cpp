#include "fem/layout.hpp"

#include "base/error.hpp"
#include "base/vector3.hpp"
#include "fem/element.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/plex.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

/// The DMPlex points that carry a cell's nodes: four vertices, positively oriented, and for order 2 its six edges.
class CellClosure {
 public:
  CellClosure(const Mesh& mesh, int order)
      : mesh_(mesh),
        dm_(mesh.dm.get()),
        order_(order),
        vertices_(stratum(dm_, 0)),
        edges_(stratum(dm_, 1)),
        x_(vertex_coordinates(dm_, vertices_)) {}

  std::array<PetscInt, 10> operator()(PetscInt cell) const {
    std::array<PetscInt, 10> points;
    points.fill(-1);
    for (int i = 0; i < 4; ++i) points[i] = vertices_.begin + mesh_.corners[4 * cell + i];
    if (order_ == 2) {
      const Closure closure(dm_, cell);
      const auto edges = std::span(closure.begin(), closure.end()).subspan(5, 6);
      for (int e = 0; e < 6; ++e) {
        points[4 + e] = joining_edge(dm_, edges, points[tet_edges[e][0]], points[tet_edges[e][1]]);
      }
    }
    return points;
  }

  Vector3<double> midpoint(PetscInt edge) const {
    const PetscInt* ends = ends_of_edge(dm_, edge);
    return 0.5 * (position(ends[0]) + position(ends[1]));
  }
  Vector3<double> position(PetscInt vertex) const {
    const double* x = x_.data() + 3 * (vertex - vertices_.begin);
    return {x[0], x[1], x[2]};
  }
  bool is_vertex(PetscInt point) const { return vertices_.contains(point); }
  PetscInt edge_begin() const { return edges_.begin; }

 private:
  const Mesh& mesh_;
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

/// The local cells of the layout, owned ones first: DMPlex points of their nodes, nodes_per_cell each.
std::vector<PetscInt> choose_cells(DM dm, const CellClosure& closure, const std::vector<char>& is_ghost,
                                   NodeLayout& layout) {
  const PointRange cells = stratum(dm, 3);
  const auto is_owned = [&](PetscInt p) { return is_ghost[p] == 0; };
  std::vector<PetscInt> points_of_cells;
  for (const bool ghosts : {false, true}) {
    for (PetscInt c = cells.begin; c < cells.end; ++c) {
      if ((is_ghost[c] != 0) != ghosts) continue;
      const auto points = closure(c);
      const auto end = points.begin() + layout.nodes_per_cell;
      if (ghosts && std::none_of(points.begin(), end, is_owned)) continue;
      layout.cell_points.push_back(c);
      points_of_cells.insert(points_of_cells.end(), points.begin(), end);
    }
    if (!ghosts) layout.num_owned_cells = static_cast<PetscInt>(layout.cell_points.size());
  }
  layout.num_local_cells = static_cast<PetscInt>(layout.cell_points.size());
  return points_of_cells;
}

/// DMPlex points of the local nodes: the owned ones in the order that keeps neighbours close, then the ghosts as they
/// appear in the cells.
std::vector<PetscInt> order_nodes(const std::vector<PetscInt>& points_of_cells, const std::vector<char>& is_ghost,
                                  NodeLayout& layout) {
  std::vector<PetscInt> provisional(is_ghost.size(), -1), points;
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
  std::ranges::transform(points_of_cells, cell_nodes.begin(), [&](PetscInt p) { return provisional[p]; });
  const NodeGraph graph = node_graph(cell_nodes, layout.nodes_per_cell, layout.num_local_nodes, layout.num_owned_nodes);
  std::vector<PetscInt> ordered = points;
  std::ranges::transform(reverse_cuthill_mckee(graph, layout.num_owned_nodes), ordered.begin(),
                         [&](PetscInt n) { return points[n]; });
  return ordered;
}

/// Sizes over all ranks. Throws InputError if there are more unknowns than integers count. Collective.
void count_globally(NodeLayout& layout) {
  check_mpi(MPI_Exscan(&layout.num_owned_nodes, &layout.first_global_node, 1, MPIU_INT, MPI_SUM, layout.comm));
  const PetscInt64 num_nodes = sum(layout.comm, static_cast<PetscInt64>(layout.num_owned_nodes));
  if (3 * num_nodes > static_cast<PetscInt64>(PETSC_MAX_INT)) {
    throw InputError(
        {}, "there are " + std::to_string(3 * num_nodes) +
                " unknowns, too many for 32-bit indices: build Pliant with a PETSc configured for 64-bit indices");
  }
  layout.num_global_nodes = static_cast<PetscInt>(num_nodes);
  layout.num_global_cells = sum(layout.comm, static_cast<PetscInt64>(layout.num_owned_cells));
}

/// Global numbers, contiguous per rank, which ghosts learn from their owners; `points`: of order_nodes. Collective.
void number_nodes(DM dm, std::size_t num_points, const std::vector<PetscInt>& points, NodeLayout& layout) {
  std::vector<PetscInt> global_of_point(num_points, -1);
  layout.node_of_point.assign(num_points, -1);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    layout.node_of_point[points[n]] = n;
    global_of_point[points[n]] = layout.first_global_node + n;
  }
  fill_ghosts(dm, global_of_point);
  std::vector<PetscInt> ghosts(points.begin() + layout.num_owned_nodes, points.end());
  std::ranges::sort(ghosts, {}, [&](PetscInt p) { return global_of_point[p]; });
  for (const PetscInt p : ghosts) {
    layout.node_of_point[p] = layout.num_owned_nodes + static_cast<PetscInt>(layout.ghost_global_nodes.size());
    layout.ghost_global_nodes.push_back(global_of_point[p]);
  }
}

/// The cells in the order of their nodes, owned and ghost cells apart.
void sort_cells(const std::vector<PetscInt>& points_of_cells, NodeLayout& layout) {
  const int npc = layout.nodes_per_cell;
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
  std::vector<PetscInt> cell_points;
  for (const PetscInt c : cell_order) {
    cell_points.push_back(layout.cell_points[c]);
    for (int a = 0; a < npc; ++a) layout.cell_nodes.push_back(layout.node_of_point[points_of_cells[c * npc + a]]);
  }
  layout.cell_points = std::move(cell_points);
}

/// The numbers that the whole mesh gives to cells and vertices.
void keep_numbers_of_mesh(const Mesh& mesh, NodeLayout& layout) {
  const PointRange cells = stratum(mesh.dm.get(), 3), vertices = stratum(mesh.dm.get(), 0);
  for (const PetscInt c : layout.cell_points) layout.cell_numbers.push_back(mesh.cell_numbers[c - cells.begin]);
  layout.vertex_numbers.assign(static_cast<std::size_t>(layout.num_local_nodes), -1);
  for (PetscInt v = vertices.begin; v < vertices.end; ++v) {
    const PetscInt node = layout.node_of_point[v];
    if (node >= 0) layout.vertex_numbers[node] = mesh.vertex_numbers[v - vertices.begin];
  }
}

bool is_curved(const Mesh& mesh, const NodeLayout& layout) {
  return layout.order == 2 && mesh.geometry_order == 2;
}

void place_nodes(const Mesh& mesh, const CellClosure& closure, const std::vector<PetscInt>& points,
                 NodeLayout& layout) {
  layout.coordinates.resize(3 * static_cast<std::size_t>(layout.num_local_nodes));
  for (const PetscInt p : points) {
    double* x = layout.coordinates.data() + 3 * layout.node_of_point[p];
    if (!closure.is_vertex(p) && is_curved(mesh, layout)) {
      std::copy_n(mesh.edge_midpoints.data() + 3 * (p - closure.edge_begin()), 3, x);
    } else {
      std::ranges::copy(closure.is_vertex(p) ? closure.position(p) : closure.midpoint(p), x);
    }
  }
}

}  // namespace

NodeLayout make_layout(const Mesh& mesh, int order) {
  DM dm = mesh.dm.get();
  NodeLayout layout;
  check(PetscObjectGetComm(reinterpret_cast<PetscObject>(dm), &layout.comm));
  layout.order = order;
  layout.nodes_per_cell = order == 1 ? 4 : 10;
  const CellClosure closure(mesh, order);
  const std::vector<char> is_ghost = ghost_points(dm);
  const std::vector<PetscInt> points_of_cells = choose_cells(dm, closure, is_ghost, layout);
  const std::vector<PetscInt> points = order_nodes(points_of_cells, is_ghost, layout);
  count_globally(layout);
  number_nodes(dm, is_ghost.size(), points, layout);
  sort_cells(points_of_cells, layout);
  keep_numbers_of_mesh(mesh, layout);
  place_nodes(mesh, closure, points, layout);
  if (is_curved(mesh, layout)) {
    mark_bent_cells(layout);
  } else {
    layout.cell_is_affine.assign(layout.num_local_cells, 1);
  }
  return layout;
}

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

PetscInt largest_cell_of(const NodeLayout& layout, const std::vector<int>& body_of_cell, int body) {
  constexpr double rounding = 1e-9;
  std::vector<double> volumes(static_cast<std::size_t>(layout.num_local_cells), 0.0);
  double largest = 0.0;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (body_of_cell[static_cast<std::size_t>(c)] != body) continue;
    const auto nodes = layout.nodes_of_cell(c);
    const Vector3<double> X = layout.position(nodes[0]);
    const auto edge = [&](std::size_t a) { return Vector3<double>(layout.position(nodes[a])) - X; };
    volumes[static_cast<std::size_t>(c)] = dot(edge(1), cross(edge(2), edge(3)));
    largest = std::max(largest, volumes[static_cast<std::size_t>(c)]);
  }
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, layout.comm));
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  PetscInt cell = -1;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const auto k = static_cast<std::size_t>(c);
    if (body_of_cell[k] != body || volumes[k] < (1.0 - rounding) * largest || layout.cell_numbers[k] >= lowest)
      continue;
    lowest = layout.cell_numbers[k];
    cell = c;
  }
  std::int64_t first = lowest;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT64_T, MPI_MIN, layout.comm));
  return lowest == first ? cell : -1;
}

Handle<Vec> make_vector(const NodeLayout& layout) {
  Handle<Vec> v;
  check(VecCreateGhostBlock(layout.comm, 3, 3 * layout.num_owned_nodes, PETSC_DECIDE,
                            static_cast<PetscInt>(layout.ghost_global_nodes.size()), layout.ghost_global_nodes.data(),
                            v.out()));
  return v;
}

void mark_bent_cells(NodeLayout& layout) {
  layout.cell_is_affine.assign(layout.num_local_cells, 1);
  if (layout.order == 1) return;
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

}  // namespace pliant
