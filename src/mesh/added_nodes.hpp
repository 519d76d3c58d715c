/// New nodes and cells of a serial mesh.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace pliant {

using CornerNodes = std::array<PetscInt, 4>;

/// Adds the nodes and cells of one body; middles of its edges are made as they are needed, once.
class AddedNodes {
 public:
  explicit AddedNodes(SerialMesh& mesh) : mesh_(mesh) {}

  PetscInt add(const std::array<double, 3>& x) {
    mesh_.coordinates.insert(mesh_.coordinates.end(), x.begin(), x.end());
    mesh_.node_tags.push_back(mesh_.num_nodes());
    return static_cast<PetscInt>(mesh_.num_nodes()) - 1;
  }
  PetscInt middle(PetscInt a, PetscInt b) {
    const auto [found, is_new] = middles_.try_emplace({std::min(a, b), std::max(a, b)}, 0);
    if (is_new) {
      std::array<double, 3> x{};
      for (std::size_t i = 0; i < 3; ++i) x[i] = 0.5 * (mesh_.node(a)[i] + mesh_.node(b)[i]);
      found->second = add(x);
    }
    return found->second;
  }
  /// The number of the new cell. `has_middles`: those of the mesh do.
  PetscInt add_cell(const CornerNodes& corners, bool has_middles) {
    mesh_.cells.insert(mesh_.cells.end(), corners.begin(), corners.end());
    mesh_.cell_tags.push_back(mesh_.num_cells());
    if (has_middles) {
      for (const auto& [i, j] : local_edges) {
        mesh_.mid_nodes.push_back(middle(corners[static_cast<std::size_t>(i)], corners[static_cast<std::size_t>(j)]));
      }
    }
    return static_cast<PetscInt>(mesh_.num_cells()) - 1;
  }

 private:
  SerialMesh& mesh_;
  std::map<std::pair<PetscInt, PetscInt>, PetscInt> middles_;
};

}  // namespace pliant
