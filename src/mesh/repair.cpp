#include "mesh/repair.hpp"

#include "mesh/curved.hpp"
#include "mesh/rod_chain.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

namespace pliant {
namespace {

using tetrahedron::Point;

// A tetrahedron is flat if its volume is below this fraction of its longest edge cubed: 1e4 times the rounding error of
// the volume for coordinates as large as the edge, far below any sliver that a mesher leaves (1e-4).
constexpr double flat_volume = 1e-11;
// Nodes closer than this, relative to the extent of the mesh, coincide.
constexpr double coincidence = 1e-10;
// A mid-edge node closer to the midpoint than this, relative to the edge's length, lies on a straight edge.
constexpr double straightness = 1e-9;

using Reasons = std::vector<std::string>;

Point corner(const SerialMesh& mesh, std::size_t cell, std::size_t i) {
  return mesh.place(mesh.cells[4 * cell + i]);
}

tetrahedron::Corners corners(const SerialMesh& mesh, std::size_t cell) {
  return {corner(mesh, cell, 0), corner(mesh, cell, 1), corner(mesh, cell, 2), corner(mesh, cell, 3)};
}

void require_distinct_names(const SerialMesh& mesh, Reasons& reasons) {
  std::set<std::pair<int, std::string>> seen;
  for (const auto& g : mesh.groups) {
    if (g.group.name.empty() || seen.insert({g.group.dimension, g.group.name}).second) continue;
    reasons.push_back("two physical groups of dimension " + std::to_string(g.group.dimension) + " have the name '" +
                      g.group.name + "': give each its own name");
  }
}

void require_finite_nodes(const SerialMesh& mesh, Reasons& reasons) {
  std::vector<std::size_t> bad;
  for (std::size_t i = 0; i < mesh.num_nodes(); ++i) {
    const double* x = mesh.node(static_cast<PetscInt>(i));
    // The square of a length must be finite too.
    const double r = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    if (!std::isfinite(r * std::sqrt(r))) bad.push_back(mesh.node_tags[i]);
  }
  if (!bad.empty())
    reasons.push_back("the coordinates are not finite numbers (or beyond 1e100) at node " + first_few(bad) +
                      "; mesh the geometry again, or correct the numbers in the file");
}

void turn_round(SerialMesh& mesh, std::size_t cell) {
  std::swap(mesh.cells[4 * cell], mesh.cells[4 * cell + 1]);
  if (mesh.mid_nodes.empty()) return;
  std::swap(mesh.mid_nodes[6 * cell + 1], mesh.mid_nodes[6 * cell + 2]);  // (1,2) and (2,0)
  std::swap(mesh.mid_nodes[6 * cell + 3], mesh.mid_nodes[6 * cell + 5]);  // (3,0) and (3,1)
}

void turn_inverted_round(SerialMesh& mesh, MeshReport& report, Reasons& reasons) {
  std::vector<std::size_t> flat, inverted;
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    const tetrahedron::Corners x = corners(mesh, c);
    const double v = tetrahedron::volume(x);
    const double longest = tetrahedron::longest_edge(x);
    if (!(std::abs(v) > flat_volume * longest * longest * longest)) {
      flat.push_back(mesh.cell_tags[c]);
    } else if (v < 0.0) {
      inverted.push_back(mesh.cell_tags[c]);
      turn_round(mesh, c);
    }
  }
  if (!flat.empty()) {
    reasons.push_back("tetrahedra without volume: element " + first_few(flat) +
                      "; remesh, or optimise the mesh in gmsh (Mesh.Optimize = 1)");
  }
  report.num_inverted_cells = static_cast<long long>(inverted.size());
  if (!inverted.empty()) {
    const std::string what = inverted.size() == 1
                                 ? "1 inverted tetrahedron was reoriented"
                                 : std::to_string(inverted.size()) + " inverted tetrahedra were reoriented";
    report.notices.push_back(what + ": element " + first_few(inverted));
  }
}

void require_distinct_cells(const SerialMesh& mesh, Reasons& reasons) {
  struct Key {
    std::array<PetscInt, 4> nodes;
    std::size_t cell;
  };
  std::vector<Key> keys(mesh.num_cells());
  for (std::size_t c = 0; c < keys.size(); ++c) {
    std::copy_n(&mesh.cells[4 * c], 4, keys[c].nodes.begin());
    std::sort(keys[c].nodes.begin(), keys[c].nodes.end());
    keys[c].cell = c;
  }
  std::sort(keys.begin(), keys.end(),
            [](const Key& a, const Key& b) { return a.nodes != b.nodes ? a.nodes < b.nodes : a.cell < b.cell; });
  std::vector<std::size_t> repeated;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].nodes == keys[i - 1].nodes) repeated.push_back(mesh.cell_tags[keys[i].cell]);
  }
  if (!repeated.empty()) {
    reasons.push_back(
        "duplicate tetrahedra (the same four nodes as another): element " + first_few(repeated) +
        "; delete one of each. Version 2.2 lists a volume of two physical groups twice: put it into one, or "
        "write version 4.1 (Mesh.MshFileVersion = 4.1)");
  }
}

/// The parts whose nodes may coincide with others.
struct MeetingParts {
  std::vector<char> is_free;           ///< per node: on one of the surfaces, or only of the frame of a rod's section
  std::vector<std::size_t> of_volume;  ///< per node: number of the volume, from 1; 0: none

  MeetingParts(const SerialMesh& mesh, std::span<const std::string> names, std::span<const AddedRod> rods)
      : is_free(mesh.num_nodes(), 0), of_volume(mesh.num_nodes(), 0) {
    for (const AddedRod& rod : rods) {
      free(mesh, rod.name, {false, false, true, true});
      free(mesh, name_of_end(rod.name, 0), {true, false, true, true});
      free(mesh, name_of_end(rod.name, 1), {false, true, true, true});
    }
    for (std::size_t g = 0; g < mesh.groups.size(); ++g) {
      const auto& [group, members] = mesh.groups[g];
      const auto is_this = [&name = group.name, &tag = group.tag](const std::string& s) {
        return s == name || s == std::to_string(tag);
      };
      if (group.dimension < 2 || std::ranges::none_of(names, is_this)) continue;
      if (group.dimension == 2) {
        for (const PetscInt node : members) is_free[static_cast<std::size_t>(node)] = 1;
        continue;
      }
      for (const PetscInt cell : members) {
        for (std::size_t i = 0; i < 4; ++i) {
          of_volume[static_cast<std::size_t>(mesh.cells[4 * static_cast<std::size_t>(cell) + i])] = g + 1;
        }
      }
    }
  }

  bool may_coincide(PetscInt node, PetscInt other) const {
    const auto a = static_cast<std::size_t>(node), b = static_cast<std::size_t>(other);
    return is_free[a] != 0 || is_free[b] != 0 || of_volume[a] != of_volume[b];
  }

 private:
  /// Corners of the cells of a volume, which may be anywhere.
  void free(const SerialMesh& mesh, const std::string& volume, const std::array<bool, 4>& is_one) {
    for (const auto& [group, members] : mesh.groups) {
      if (group.dimension != 3 || group.name != volume) continue;
      for (const PetscInt cell : members) {
        for (std::size_t i = 0; i < 4; ++i) {
          if (is_one[i]) is_free[static_cast<std::size_t>(mesh.cells[4 * static_cast<std::size_t>(cell) + i])] = 1;
        }
      }
    }
  }
};

/// Finds nodes that coincide: sorts along a direction in which lattice nodes do not tie, and compares near neighbours.
void require_distinct_places(const SerialMesh& mesh, PetscInt num_vertices, const MeetingParts& parts,
                             Reasons& reasons) {
  constexpr Point direction{0.6213412, 0.5177432, 0.5881174};  // generic; a unit vector to 6 digits
  double extent = 0.0;
  for (int k = 0; k < 3; ++k) {
    double lower = mesh.coordinates[static_cast<std::size_t>(k)], upper = lower;
    for (PetscInt i = 0; i < num_vertices; ++i) {
      lower = std::min(lower, mesh.node(i)[k]);
      upper = std::max(upper, mesh.node(i)[k]);
    }
    extent = std::max(extent, upper - lower);
  }
  const double near = coincidence * extent;
  std::vector<std::pair<double, PetscInt>> along(static_cast<std::size_t>(num_vertices));
  for (PetscInt i = 0; i < num_vertices; ++i) {
    const double* x = mesh.node(i);
    along[static_cast<std::size_t>(i)] = {direction[0] * x[0] + direction[1] * x[1] + direction[2] * x[2], i};
  }
  std::sort(along.begin(), along.end());
  std::vector<std::size_t> coinciding;
  for (std::size_t i = 0; i < along.size(); ++i) {
    for (std::size_t j = i + 1; j < along.size() && along[j].first - along[i].first <= 2 * near; ++j) {
      const double* x = mesh.node(along[i].second);
      const double* y = mesh.node(along[j].second);
      if (std::hypot(x[0] - y[0], x[1] - y[1], x[2] - y[2]) > near) continue;
      if (parts.may_coincide(along[i].second, along[j].second)) continue;
      coinciding.push_back(mesh.node_tags[static_cast<std::size_t>(along[j].second)]);
      break;
    }
  }
  if (coinciding.empty()) return;
  std::sort(coinciding.begin(), coinciding.end());
  coinciding.erase(std::unique(coinciding.begin(), coinciding.end()), coinciding.end());
  reasons.push_back(
      "nodes that coincide with another node: " + first_few(coinciding) +
      "; the parts that meet there are not joined. Join them in gmsh (Coherence or BooleanFragments in the "
      "geometry, Coherence Mesh on a mesh), tie their surfaces in the input (`tied_to`), let contact move them apart "
      "(`contact.start: resolve`), or leave a gap between them");
}

/// Numbers the corners first, then the mid-edge nodes, each in the file's order; drops all other nodes.
PetscInt drop_orphans(SerialMesh& mesh, MeshReport& report) {
  std::vector<PetscInt> number(mesh.num_nodes(), -1);
  for (const PetscInt node : mesh.cells) number[static_cast<std::size_t>(node)] = 0;
  for (const PetscInt node : mesh.mid_nodes) {
    auto& n = number[static_cast<std::size_t>(node)];
    if (n != 0) n = 1;
  }
  PetscInt next = 0, num_vertices = 0;
  std::vector<double> coordinates;
  std::vector<std::size_t> tags, orphans;
  std::vector<PetscInt> renumbered(mesh.num_nodes(), -1);
  for (const int kind : {0, 1}) {
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (number[i] != kind) continue;
      renumbered[i] = next++;
      tags.push_back(mesh.node_tags[i]);
      coordinates.insert(coordinates.end(), &mesh.coordinates[3 * i], &mesh.coordinates[3 * i] + 3);
    }
    if (kind == 0) num_vertices = next;
  }
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) orphans.push_back(mesh.node_tags[i]);
  }
  for (auto& node : mesh.cells) node = renumbered[static_cast<std::size_t>(node)];
  for (auto& node : mesh.mid_nodes) node = renumbered[static_cast<std::size_t>(node)];
  for (auto& g : mesh.groups) {
    if (g.group.dimension == 3) continue;
    for (auto& node : g.members) node = renumbered[static_cast<std::size_t>(node)];
  }
  mesh.coordinates = std::move(coordinates);
  mesh.node_tags = std::move(tags);
  report.num_orphan_nodes = static_cast<long long>(orphans.size());
  if (!orphans.empty()) {
    report.notices.push_back(std::to_string(orphans.size()) + " nodes that no tetrahedron uses were dropped: node " +
                             first_few(orphans));
  }
  return num_vertices;
}

/// Neighbours must agree on the mid-edge node of their common edge, and that node must not be a corner.
void require_one_mid_node_per_edge(const SerialMesh& mesh, PetscInt num_vertices, Reasons& reasons) {
  struct Edge {
    PetscInt first, second, mid, cell;
  };
  std::vector<Edge> edges;
  edges.reserve(mesh.mid_nodes.size());
  std::vector<std::size_t> bad;
  for (std::size_t i = 0; i < mesh.mid_nodes.size(); ++i) {
    const std::size_t c = i / 6, e = i % 6;
    const PetscInt a = mesh.cells[4 * c + static_cast<std::size_t>(local_edges[e][0])];
    const PetscInt b = mesh.cells[4 * c + static_cast<std::size_t>(local_edges[e][1])];
    edges.push_back({std::min(a, b), std::max(a, b), mesh.mid_nodes[i], static_cast<PetscInt>(c)});
    if (mesh.mid_nodes[i] < num_vertices) bad.push_back(mesh.cell_tags[c]);
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.first, a.second, a.cell) < std::tie(b.first, b.second, b.cell);
  });
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (edges[i].first != edges[i - 1].first || edges[i].second != edges[i - 1].second) continue;
    if (edges[i].mid != edges[i - 1].mid) bad.push_back(mesh.cell_tags[static_cast<std::size_t>(edges[i].cell)]);
  }
  if (bad.empty()) return;
  std::sort(bad.begin(), bad.end());
  bad.erase(std::unique(bad.begin(), bad.end()), bad.end());
  reasons.push_back(
      "second-order tetrahedra that disagree with a neighbour on the mid-edge node of an edge, or use a corner for it: "
      "element " +
      first_few(bad) + "; mesh all volumes together with Mesh.ElementOrder = 2");
}

void require_unfolded_curves(const SerialMesh& mesh, Reasons& reasons) {
  std::vector<std::size_t> folded;
  for (std::size_t c = 0; c < mesh.mid_nodes.size() / 6; ++c) {
    std::array<Point, 10> x;
    for (std::size_t i = 0; i < 10; ++i) {
      x[i] = mesh.place(i < 4 ? mesh.cells[4 * c + i] : mesh.mid_nodes[6 * c + i - 4]);
    }
    if (!(tetrahedron::relative_jacobian(x) > 0.0)) folded.push_back(mesh.cell_tags[c]);
  }
  if (folded.empty()) return;
  reasons.push_back("folded curved tetrahedra: element " + first_few(folded) +
                    "; mesh it finer there, set Mesh.HighOrderOptimize = 2 in gmsh, or use first-order elements");
}

void forget_straight_mid_nodes(SerialMesh& mesh, PetscInt num_vertices, MeshReport& report) {
  if (mesh.mid_nodes.empty()) return;
  for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
    for (std::size_t e = 0; e < 6; ++e) {
      const double* a = mesh.node(mesh.cells[4 * c + static_cast<std::size_t>(local_edges[e][0])]);
      const double* b = mesh.node(mesh.cells[4 * c + static_cast<std::size_t>(local_edges[e][1])]);
      const double* m = mesh.node(mesh.mid_nodes[6 * c + e]);
      double offset = 0.0, length = 0.0;
      for (int k = 0; k < 3; ++k) {
        offset += std::pow(m[k] - 0.5 * (a[k] + b[k]), 2);
        length += std::pow(b[k] - a[k], 2);
      }
      if (offset > straightness * straightness * length) return;
    }
  }
  mesh.mid_nodes.clear();
  mesh.coordinates.resize(3 * static_cast<std::size_t>(num_vertices));
  mesh.node_tags.resize(static_cast<std::size_t>(num_vertices));
  report.notices.push_back("all edges of the second-order mesh are straight: it is used as a first-order mesh");
}

void throw_if_any(const Reasons& reasons) {
  if (!reasons.empty()) throw MeshDefect(reasons);
}

}  // namespace

PetscInt repair(SerialMesh& mesh, std::span<const std::string> meeting_parts, std::span<const AddedRod> rods,
                MeshReport& report) {
  Reasons reasons;
  require_distinct_names(mesh, reasons);
  require_finite_nodes(mesh, reasons);
  throw_if_any(reasons);
  const PetscInt num_vertices = drop_orphans(mesh, report);
  turn_inverted_round(mesh, report, reasons);
  require_distinct_cells(mesh, reasons);
  require_distinct_places(mesh, num_vertices, MeetingParts(mesh, meeting_parts, rods), reasons);
  require_one_mid_node_per_edge(mesh, num_vertices, reasons);
  throw_if_any(reasons);
  require_unfolded_curves(mesh, reasons);
  throw_if_any(reasons);
  forget_straight_mid_nodes(mesh, num_vertices, report);
  report.is_straightened = mesh.is_straightened;
  return num_vertices;
}

}  // namespace pliant
