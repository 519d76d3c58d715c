#include "mesh/dual_graph.hpp"

#include "mesh/disjoint_sets.hpp"
#include "mesh/tetrahedron.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <span>

namespace pliant {
namespace {

constexpr idx_t seed = 20;

void require_success(int status, const char* call) {
  if (status == METIS_OK) return;
  if (status == METIS_ERROR_MEMORY) throw std::bad_alloc();
  throw std::runtime_error(std::string("METIS failed in ") + call + ", status " + std::to_string(status));
}

std::span<const PetscInt> corners_of(const SerialMesh& mesh, std::size_t cell) {
  return {&mesh.cells[4 * cell], 4};
}

/// Local index of the one corner of `cell` that `other` does not have.
int lone_corner(std::span<const PetscInt> cell, std::span<const PetscInt> other) {
  for (std::size_t i = 0; i < 4; ++i) {
    if (std::find(other.begin(), other.end(), cell[i]) == other.end()) return static_cast<int>(i);
  }
  return 0;  // unreachable: cells are distinct
}

/// Whether both cells lie on the same side of their common facet, which is opposite to corner i of `cell`.
bool same_side(const SerialMesh& mesh, std::span<const PetscInt> cell, int i, PetscInt opposite) {
  tetrahedron::Corners x;
  for (std::size_t k = 0; k < 4; ++k) x[k] = mesh.place(static_cast<int>(k) == i ? opposite : cell[k]);
  return tetrahedron::volume(x) > 0.0;
}

void notice_parts(const SerialMesh& mesh, const DualGraph& graph, PetscInt num_vertices, const AddedParts& added,
                  MeshReport& report) {
  DisjointSets vertices(static_cast<std::size_t>(num_vertices));
  std::vector<char> is_used(static_cast<std::size_t>(num_vertices), 0);
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    if (c >= added.first_of_rods && c < added.first_of_rods + added.num_of_rods) continue;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto vertex = static_cast<std::size_t>(mesh.cells[4 * c + i]);
      is_used[vertex] = 1;
      vertices.join(static_cast<std::size_t>(mesh.cells[4 * c]), vertex);
    }
  }
  const auto num_unused = static_cast<std::size_t>(std::ranges::count(is_used, 0));
  const std::size_t parts = vertices.count() - num_unused;
  if (parts > 1 + added.num_parts) {
    report.notices.push_back("the mesh has " + std::to_string(parts - added.num_parts) + " disconnected parts");
  }
  const std::size_t by_facets = graph.num_components() - added.num_of_rods;
  if (by_facets > parts) {
    report.notices.push_back(std::to_string(by_facets - parts + 1) +
                             " parts are connected only by an edge or a node: they hinge freely there");
  }
}

using Pair = std::array<idx_t, 2>;  // of cells that have a facet in common

/// Facets are found at their lowest node, which few others have.
std::vector<Pair> pairs_at_facets(const SerialMesh& mesh) {
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> first(mesh.num_nodes(), none), next(4 * mesh.num_cells());
  std::vector<std::array<PetscInt, 2>> others(next.size());  // the other nodes of facet i of cell c at 4 c + i
  std::vector<Pair> pairs;
  pairs.reserve(2 * mesh.num_cells());
  for (std::size_t at = 0; at < next.size(); ++at) {
    std::array<PetscInt, 3> nodes{};
    for (std::size_t k = 0; k < 3; ++k) {
      nodes[k] = mesh.cells[at / 4 * 4 + static_cast<std::size_t>(local_facets[at % 4][k])];
    }
    std::ranges::sort(nodes);
    others[at] = {nodes[1], nodes[2]};
    std::size_t& head = first[static_cast<std::size_t>(nodes[0])];
    for (std::size_t facet = head; facet != none; facet = next[facet]) {
      if (others[facet] == others[at]) pairs.push_back({static_cast<idx_t>(facet / 4), static_cast<idx_t>(at / 4)});
    }
    next[at] = head;
    head = at;
  }
  return pairs;
}

/// Pairs of cells with so many common nodes.
std::vector<Pair> pairs_by_metis(const SerialMesh& mesh, CommonNodes common) {
  auto num_elements = static_cast<idx_t>(mesh.num_cells());
  auto num_nodes = static_cast<idx_t>(mesh.num_nodes());
  std::vector<idx_t> offsets(mesh.num_cells() + 1);
  for (std::size_t c = 0; c < offsets.size(); ++c) offsets[c] = static_cast<idx_t>(4 * c);
  std::vector<idx_t> cells(mesh.cells.begin(), mesh.cells.end());
  idx_t num_common = static_cast<idx_t>(common), numbering = 0;
  idx_t* xadj = nullptr;
  idx_t* adjncy = nullptr;
  require_success(METIS_MeshToDual(&num_elements, &num_nodes, offsets.data(), cells.data(), &num_common, &numbering,
                                   &xadj, &adjncy),
                  "METIS_MeshToDual");
  std::vector<Pair> pairs;
  for (idx_t c = 0; c < num_elements; ++c) {
    for (idx_t i = xadj[c]; i < xadj[c + 1]; ++i) {
      if (c < adjncy[i]) pairs.push_back({c, adjncy[i]});
    }
  }
  METIS_Free(xadj);
  METIS_Free(adjncy);
  return pairs;
}

}  // namespace

DualGraph::DualGraph(const SerialMesh& mesh, CommonNodes common)
    : num_cells_(mesh.num_cells()), offsets_(mesh.num_cells() + 1, 0) {
  if (4 * mesh.num_cells() > static_cast<std::size_t>(std::numeric_limits<idx_t>::max())) {
    throw MeshDefect("it has " + std::to_string(mesh.num_cells()) +
                     " tetrahedra, more than METIS can partition: use a coarser mesh and `refine`");
  }
  const std::vector<Pair> pairs =
      common == CommonNodes::of_facets ? pairs_at_facets(mesh) : pairs_by_metis(mesh, common);
  for (const Pair& pair : pairs) {
    for (const idx_t cell : pair) ++offsets_[static_cast<std::size_t>(cell) + 1];
  }
  for (std::size_t c = 0; c < num_cells_; ++c) offsets_[c + 1] += offsets_[c];
  adjacency_.resize(2 * pairs.size());
  std::vector<idx_t> end(offsets_.begin(), offsets_.end() - 1);
  for (const auto& [a, b] : pairs) {
    adjacency_[static_cast<std::size_t>(end[static_cast<std::size_t>(a)]++)] = b;
    adjacency_[static_cast<std::size_t>(end[static_cast<std::size_t>(b)]++)] = a;
  }
}

std::size_t DualGraph::num_components() const {
  DisjointSets cells(num_cells_);
  for (std::size_t c = 0; c < num_cells_; ++c) {
    for (const idx_t n : neighbours(c)) cells.join(c, static_cast<std::size_t>(n));
  }
  return cells.count();
}

std::vector<PetscInt> DualGraph::partition(int num_parts, long long& edge_cut) const {
  std::vector<idx_t> part(num_cells_, 0);
  edge_cut = 0;
  if (num_parts == 1) return std::vector<PetscInt>(num_cells_, 0);
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = seed;
  options[METIS_OPTION_OBJTYPE] = METIS_OBJTYPE_CUT;
  options[METIS_OPTION_CONTIG] = num_components() == 1 ? 1 : 0;
  auto num_vertices = static_cast<idx_t>(num_cells_);
  idx_t num_constraints = 1, parts = num_parts, cut = 0;
  require_success(METIS_PartGraphKway(&num_vertices, &num_constraints, offsets_.data(), adjacency_.data(), nullptr,
                                      nullptr, nullptr, &parts, nullptr, nullptr, options.data(), &cut, part.data()),
                  "METIS_PartGraphKway");
  // With few cells METIS may leave a part empty: it gets a cell of the largest part.
  std::vector<std::size_t> sizes(static_cast<std::size_t>(num_parts), 0);
  for (const idx_t p : part) ++sizes[static_cast<std::size_t>(p)];
  for (auto empty = std::find(sizes.begin(), sizes.end(), 0u); empty != sizes.end();
       empty = std::find(sizes.begin(), sizes.end(), 0u)) {
    const auto largest = std::max_element(sizes.begin(), sizes.end());
    *std::find(part.begin(), part.end(), static_cast<idx_t>(largest - sizes.begin())) =
        static_cast<idx_t>(empty - sizes.begin());
    --*largest;
    ++*empty;
  }
  for (std::size_t c = 0; c < num_cells_; ++c) {
    for (const idx_t n : neighbours(c)) {
      const auto d = static_cast<std::size_t>(n);
      if (c < d && part[c] != part[d]) ++edge_cut;
    }
  }
  return {part.begin(), part.end()};
}

void check_connections(const SerialMesh& mesh, const DualGraph& graph, PetscInt num_vertices, const AddedParts& added,
                       MeshReport& report) {
  std::vector<std::size_t> overlapping, crowded;
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    const auto cell = corners_of(mesh, c);
    std::array<int, 4> at_facet{};
    for (const idx_t n : graph.neighbours(c)) {
      const auto other = corners_of(mesh, static_cast<std::size_t>(n));
      const int i = lone_corner(cell, other);
      if (++at_facet[static_cast<std::size_t>(i)] == 2) crowded.push_back(mesh.cell_tags[c]);
      const PetscInt opposite = other[static_cast<std::size_t>(lone_corner(other, cell))];
      if (same_side(mesh, cell, i, opposite)) overlapping.push_back(mesh.cell_tags[c]);
    }
  }
  std::vector<std::string> reasons;
  if (!crowded.empty()) {
    reasons.push_back("more than two tetrahedra share a facet: element " + first_few(crowded) +
                      "; volumes overlap there: join them in gmsh (BooleanFragments) before meshing");
  } else if (!overlapping.empty()) {
    overlapping.erase(std::unique(overlapping.begin(), overlapping.end()), overlapping.end());
    reasons.push_back("tetrahedra overlap a neighbour (both lie on the same side of their common facet): element " +
                      first_few(overlapping) + "; the mesh is folded there, remesh it");
  }
  if (!reasons.empty()) throw MeshDefect(reasons);
  notice_parts(mesh, graph, num_vertices, added, report);
}

}  // namespace pliant
