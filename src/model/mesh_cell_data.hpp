/// Data of the mesh file for its cells (elements), on the cells of this rank.
#pragma once

#include "fem/layout.hpp"
#include "input/cell_data.hpp"
#include "mesh/mesh.hpp"

namespace pliant {

class MeshCellData final : public CellData {
 public:
  /// Both must outlive the object.
  MeshCellData(const Mesh& mesh, const NodeLayout& layout) : mesh_(mesh), layout_(layout) {}

  std::size_t find(const std::string& name, int components, const Location& where) const override;
  std::span<const double> at(std::size_t data, PetscInt cell) const override;
  const std::string& name(std::size_t data) const override { return mesh_.cell_data[data].name; }

 private:
  const Mesh& mesh_;
  const NodeLayout& layout_;
};

}  // namespace pliant
