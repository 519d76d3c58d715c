#include "mesh/added_rods.hpp"

#include "mesh/added_nodes.hpp"
#include "mesh/added_volumes.hpp"
#include "mesh/rod_chain.hpp"

#include <map>

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
      for (const PetscInt node : members) {
        const double* x = mesh_.node(node);
        axis_.try_emplace({x[0], x[1], x[2]}, node);
      }
    }
  }
  /// A node on the axis of a rod: where another rod has one, it is that.
  PetscInt on_axis(const Place& x) {
    const auto [found, is_new] = axis_.try_emplace(x, 0);
    if (is_new) found->second = added_.add(x);
    return found->second;
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
  for (const AddedRod& rod : rods) {
    const RodChain chain = rod_chain(rod, points_of(rod, curves));
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
