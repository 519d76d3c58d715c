/// A mesh whose nodes are moved for a while.
#pragma once

#include "mesh/mesh.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace pliant {

/// Moves places, xyz after one another, from X to X + amount X_j e_i; `entry`: i and j.
void strain(std::array<std::size_t, 2> entry, double amount, std::span<double> places);

/// While the object lives, all vertices of the mesh are strained so.
class StrainedMesh {
 public:
  /// The mesh outlives the object.
  StrainedMesh(const Mesh& mesh, std::array<std::size_t, 2> entry, double amount);
  StrainedMesh(const StrainedMesh&) = delete;
  StrainedMesh& operator=(const StrainedMesh&) = delete;
  ~StrainedMesh();

 private:
  Vec coordinates_ = nullptr;  // borrowed from the mesh
  Handle<Vec> before_;
};

}  // namespace pliant
