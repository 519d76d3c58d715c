#include "mesh/tetrahedra_plex.hpp"

#include <algorithm>
#include <utility>

#include <petscdmplex.h>

namespace pliant {
namespace {

/// Corners of the facets in PETSc's order, each anticlockwise seen from outside.
constexpr std::array<std::array<std::size_t, 3>, 4> facets_of_cell{{{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {2, 1, 3}}};

/// Numbers distinct edges (two vertices) or facets (three) in order of appearance. `Size`: number of vertices besides
/// the lowest one.
template <std::size_t Size>
class Parts {
 public:
  using Rest = std::array<PetscInt, Size>;

  Parts(PetscInt num_vertices, std::size_t expected) : first_(static_cast<std::size_t>(num_vertices), -1) {
    rests_.reserve(expected);
    next_.reserve(expected);
  }
  /// The number of the edge or facet, and whether it is new. Vertices in ascending order. Each vertex is the lowest one
  /// of only a few, which are searched linearly.
  std::pair<PetscInt, bool> number(PetscInt lowest, const Rest& rest) {
    PetscInt* link = &first_[static_cast<std::size_t>(lowest)];
    while (*link >= 0) {
      if (rests_[static_cast<std::size_t>(*link)] == rest) return {*link, false};
      link = &next_[static_cast<std::size_t>(*link)];
    }
    const auto number = static_cast<PetscInt>(rests_.size());
    *link = number;
    rests_.push_back(rest);
    next_.push_back(-1);
    return {number, true};
  }
  PetscInt size() const { return static_cast<PetscInt>(rests_.size()); }

 private:
  std::vector<PetscInt> first_;  // first item of each lowest vertex, -1 for none
  std::vector<PetscInt> next_;   // next item of the same lowest vertex
  std::vector<Rest> rests_;
};

/// Edges and facets as they lie on vertices and edges, lower vertices first.
struct Topology {
  std::vector<std::array<PetscInt, 2>> edges;         // vertices a < b
  std::vector<std::array<PetscInt, 3>> facets;        // edges ab, bc, ac of vertices a < b < c
  std::vector<std::array<PetscInt, 4>> cells;         // facets
  std::vector<std::array<PetscInt, 4>> orientations;  // of the facets as the cell sees them
};

/// The orientations in which cells see facets, as PETSc counts them.
class Orientations {
 public:
  Orientations() {
    constexpr std::array<PetscInt, 3> ascending{0, 1, 2};
    auto listed = ascending;
    do check(DMPolytopeGetVertexOrientation(DM_POLYTOPE_TRIANGLE, ascending.data(), listed.data(), &of(listed)));
    while (std::ranges::next_permutation(listed).found);
  }
  /// How a cell with this list of vertices sees the facet that has them in ascending order.
  PetscInt operator()(const std::array<PetscInt, 3>& listed) const { return table_[index(listed)]; }

 private:
  static std::size_t index(const std::array<PetscInt, 3>& v) {
    return (v[0] < v[1] ? 4u : 0u) + (v[1] < v[2] ? 2u : 0u) + (v[0] < v[2] ? 1u : 0u);
  }
  PetscInt& of(const std::array<PetscInt, 3>& listed) { return table_[index(listed)]; }
  std::array<PetscInt, 8> table_{};
};

Topology find_parts(std::span<const PetscInt> corners, PetscInt num_vertices) {
  const std::size_t num_cells = corners.size() / 4;
  Topology topology;
  topology.cells.resize(num_cells);
  topology.orientations.resize(num_cells);
  // Estimates for large meshes: two facets and seven sixths of an edge per tetrahedron, plus the surface.
  Parts<2> facets(num_vertices, 2 * num_cells + num_cells / 4);
  Parts<1> edges(num_vertices, num_cells + num_cells / 3);
  topology.facets.reserve(2 * num_cells + num_cells / 4);
  topology.edges.reserve(num_cells + num_cells / 3);
  const Orientations orientation;
  const auto edge = [&](PetscInt a, PetscInt b) {
    const auto [number, is_new] = edges.number(a, {b});
    if (is_new) topology.edges.push_back({a, b});
    return number;
  };
  for (std::size_t c = 0; c < num_cells; ++c) {
    for (std::size_t f = 0; f < 4; ++f) {
      std::array<PetscInt, 3> listed{};
      for (std::size_t i = 0; i < 3; ++i) listed[i] = corners[4 * c + facets_of_cell[f][i]];
      auto ascending = listed;
      std::ranges::sort(ascending);
      const auto [a, b, d] = ascending;
      const auto [number, is_new] = facets.number(a, {b, d});
      if (is_new) topology.facets.push_back({edge(a, b), edge(b, d), edge(a, d)});
      topology.cells[c][f] = number;
      topology.orientations[c][f] = orientation(listed);
    }
  }
  return topology;
}

/// First points of the kinds, in the order in which PETSc numbers them.
struct Numbering {
  PetscInt vertices, facets, edges, end;
  Numbering(const Topology& topology, PetscInt num_vertices)
      : vertices(static_cast<PetscInt>(topology.cells.size())),
        facets(vertices + num_vertices),
        edges(facets + static_cast<PetscInt>(topology.facets.size())),
        end(edges + static_cast<PetscInt>(topology.edges.size())) {}
};

void set_cone_sizes(DM dm, const Numbering& first) {
  check(DMPlexSetChart(dm, 0, first.end));
  for (PetscInt p = 0; p < first.vertices; ++p) check(DMPlexSetConeSize(dm, p, 4));
  for (PetscInt p = first.facets; p < first.edges; ++p) check(DMPlexSetConeSize(dm, p, 3));
  for (PetscInt p = first.edges; p < first.end; ++p) check(DMPlexSetConeSize(dm, p, 2));
  check(DMSetUp(dm));
}

/// PETSc stores the cones of all points one after another.
void set_cones(DM dm, const Topology& topology, const Numbering& first) {
  PetscInt *point = nullptr, *orientation = nullptr;
  check(DMPlexGetCones(dm, &point));
  check(DMPlexGetConeOrientations(dm, &orientation));
  for (std::size_t c = 0; c < topology.cells.size(); ++c) {
    for (const PetscInt facet : topology.cells[c]) *point++ = first.facets + facet;
    orientation = std::ranges::copy(topology.orientations[c], orientation).out;
  }
  // A facet abc runs along its edges ab and bc, and against ac.
  constexpr std::array<PetscInt, 3> along{0, 0, -1};
  for (const auto& facet : topology.facets) {
    for (const PetscInt edge : facet) *point++ = first.edges + edge;
    orientation = std::ranges::copy(along, orientation).out;
  }
  for (const auto& edge : topology.edges) {
    for (const PetscInt vertex : edge) *point++ = first.vertices + vertex;
  }
  check(DMPlexSymmetrize(dm));
  check(DMPlexStratify(dm));
}

/// Set before PETSc asks for it: PETSc would compute it point by point.
void set_cell_types(DM dm, const Numbering& first) {
  check(DMCreateLabel(dm, "celltype"));
  DMLabel types = nullptr;
  check(DMPlexGetCellTypeLabel(dm, &types));
  const auto set = [&](DMPolytopeType type, PetscInt begin, PetscInt end) {
    if (begin < end) check(DMLabelSetStratumBounds(types, type, begin, end));
  };
  set(DM_POLYTOPE_TETRAHEDRON, 0, first.vertices);
  set(DM_POLYTOPE_POINT, first.vertices, first.facets);
  set(DM_POLYTOPE_TRIANGLE, first.facets, first.edges);
  set(DM_POLYTOPE_SEGMENT, first.edges, first.end);
}

}  // namespace

Handle<DM> make_tetrahedra_plex(MPI_Comm comm, std::span<const PetscInt> cells, std::span<const double> coordinates) {
  const auto num_vertices = static_cast<PetscInt>(coordinates.size() / 3);
  Handle<DM> dm;
  check(DMCreate(comm, dm.out()));
  check(DMSetType(dm.get(), DMPLEX));
  check(DMSetDimension(dm.get(), 3));
  {
    const Topology topology = find_parts(cells, num_vertices);
    const Numbering first(topology, num_vertices);
    set_cone_sizes(dm.get(), first);
    set_cones(dm.get(), topology, first);
    set_cell_types(dm.get(), first);
  }
  check(DMPlexBuildCoordinatesFromCellList(dm.get(), 3, coordinates.data()));
  return dm;
}

}  // namespace pliant
