#include "mesh/added_rods.hpp"

#include "mesh/added_nodes.hpp"
#include "mesh/added_volumes.hpp"
#include "mesh/rod_chain.hpp"
#include "mesh/tetrahedron.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

using Place = std::array<double, 3>;

/// The nodes of rods by their places.
class NodesOfRods {
 public:
  explicit NodesOfRods(SerialMesh& mesh) : mesh_(mesh), added_(mesh) {}

  /// Takes the nodes of a curve of the mesh as they are.
  void take_curve(const std::string& name) {
    for (const auto& [group, members] : mesh_.groups) {
      if (group.dimension != 1 || (group.name != name && std::to_string(group.tag) != name)) continue;
      for (const PetscInt node : members) axis_.try_emplace(mesh_.place(node), node);
    }
  }
  /// A node on the axis of a rod: where another rod has one, it is that.
  PetscInt on_axis(const Place& x) {
    const auto [found, is_new] = axis_.try_emplace(x, 0);
    if (is_new) found->second = added_.add(x);
    return found->second;
  }
  /// The nodes of a curve of the mesh at these points, in their order.
  std::vector<PetscInt> on_curve(std::span<const Place> points) const {
    std::vector<PetscInt> nodes;
    for (const Place& x : points) nodes.push_back(axis_.at(x));
    return nodes;
  }
  /// `place`: of the tetrahedron in its rod; `is_axis`: of its corners.
  PetscInt add(const CornerPlaces& corners, const std::array<bool, 4>& is_axis) {
    CornerNodes nodes{};
    for (std::size_t k = 0; k < 4; ++k) nodes[k] = is_axis[k] ? on_axis(corners[k]) : added_.add(corners[k]);
    return added_.add_cell(nodes, mesh_.geometry_order() == 2);
  }

 private:
  SerialMesh& mesh_;
  AddedNodes added_;
  std::map<Place, PetscInt> axis_;
};

/// How thick the cells of a mesh are around edges between marked nodes.
class CellsAround {
 public:
  CellsAround(const SerialMesh& mesh, const std::vector<char>& is_marked) : mesh_(mesh) {
    for (std::size_t c = 0; c < mesh.num_cells(); ++c) {
      const PetscInt* nodes = &mesh.cells[4 * c];
      for (const auto& [i, j] : local_edges) {
        const PetscInt a = nodes[i], b = nodes[j];
        if (is_marked[static_cast<std::size_t>(a)] == 0 || is_marked[static_cast<std::size_t>(b)] == 0) continue;
        tetrahedron::Corners x;
        for (std::size_t k = 0; k < 4; ++k) x[k] = mesh_.place(nodes[k]);
        volumes_[std::minmax(a, b)] += std::abs(tetrahedron::volume(x));
      }
    }
  }
  /// The least volume around an edge of a chain divided by the edge's length [m^2]; negative if there is none.
  double least_section(std::span<const PetscInt> chain) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 1; k < chain.size(); ++k) {
      const auto volume = volumes_.find(std::minmax(chain[k - 1], chain[k]));
      if (volume == volumes_.end()) return -1.0;
      least = std::min(least, volume->second / norm(mesh_.place(chain[k]) - mesh_.place(chain[k - 1])));
    }
    return least;
  }

 private:
  const SerialMesh& mesh_;
  std::map<std::pair<PetscInt, PetscInt>, double> volumes_;  // around edges, of the lower and the higher node
};

/// For each rod, whether it is a fibre.
std::vector<char> find_fibres(std::span<const AddedRod> rods, std::span<const std::vector<Place>> points,
                              const NodesOfRods& nodes, const SerialMesh& mesh) {
  std::vector<char> is_fibre(rods.size(), 0), is_marked(mesh.num_nodes(), 0);
  std::vector<std::vector<PetscInt>> chains(rods.size());
  bool any = false;
  for (std::size_t r = 0; r < rods.size(); ++r) {
    if (rods[r].curve.empty() || std::isinf(rods[r].fibre_beside)) continue;
    chains[r] = nodes.on_curve(points[r]);
    for (const PetscInt node : chains[r]) is_marked[static_cast<std::size_t>(node)] = 1;
    any = true;
  }
  if (!any) return is_fibre;
  const CellsAround cells(mesh, is_marked);
  for (std::size_t r = 0; r < rods.size(); ++r) {
    if (chains[r].empty()) continue;
    const double section = cells.least_section(chains[r]);
    is_fibre[r] = section >= rods[r].fibre_beside ? 1 : 0;
    if (is_fibre[r] != 0 || rods[r].fibre_beside > 0.0) continue;
    throw InputError(rods[r].where,
                     fmt::format("rod '{}' does not resist bending, and its curve has an edge that is not of a body: "
                                 "embed the curve in the volume (in gmsh: BooleanFragments, or Curve {{1}} In Volume "
                                 "{{1}}), or remove 'bending: false'",
                                 rods[r].name));
  }
  return is_fibre;
}

}  // namespace

void add_rods(std::span<const AddedRod> rods, std::span<const MeshCurve> curves, SerialMesh& mesh) {
  if (rods.empty()) return;
  NodesOfRods nodes(mesh);
  for (const AddedRod& rod : rods) {
    if (rod.curve.empty()) continue;
    nodes.take_curve(rod.curve);
    if (mesh.geometry_order() == 1) continue;
    throw InputError(rod.where,
                     fmt::format("rod '{}' follows a curve of a mesh of second-order elements, whose edges may "
                                 "be curved: use first-order elements (Mesh.ElementOrder = 1) for the mesh; "
                                 "'element: P2' is possible with them",
                                 rod.name));
  }
  const std::vector<std::vector<Place>> points = joined_points_of(rods, curves);
  const std::vector<char> is_fibre = find_fibres(rods, points, nodes, mesh);
  for (std::size_t r = 0; r < rods.size(); ++r) {
    const AddedRod& rod = rods[r];
    if (is_fibre[r] != 0) {
      add_volume_group(rod.name, {}, mesh);
      continue;
    }
    const RodChain chain = rod_chain(rod, points[r]);
    if (!chain.fault.empty()) throw InputError(rod.where, fmt::format("rod '{}' {}", rod.name, chain.fault));
    std::vector<PetscInt> members;
    for (const CornerPlaces& corners : chain.segments)
      members.push_back(nodes.add(corners, {true, true, false, false}));
    add_volume_group(rod.name, std::move(members), mesh);
    if (chain.ends[0]) {
      add_volume_group(name_of_end(rod.name, 0), {nodes.add(*chain.ends[0], {false, true, false, false})}, mesh);
    }
    if (chain.ends[1]) {
      add_volume_group(name_of_end(rod.name, 1), {nodes.add(*chain.ends[1], {true, false, false, false})}, mesh);
    }
  }
  complete_cell_data(mesh);
}

}  // namespace pliant
