/// Data that the mesh file gives for its elements, on the cells of this rank.
#pragma once

#include "base/error.hpp"
#include "fem/layout.hpp"
#include "mesh/mesh.hpp"

#include <span>
#include <string>

namespace pliant {

class CellData {
 public:
  /// Both outlive the object.
  CellData(const Mesh& mesh, const NodeLayout& layout) : mesh_(mesh), layout_(layout) {}

  /// The place of the data of that name in the mesh. Throws InputError if there are none, or if they have other numbers
  /// of components.
  std::size_t find(const std::string& name, int components, const Location& where) const;
  /// The values on a local cell, NaN where the file has none.
  std::span<const double> at(std::size_t data, PetscInt cell) const;
  const std::string& name(std::size_t data) const { return mesh_.cell_data[data].name; }

 private:
  const Mesh& mesh_;
  const NodeLayout& layout_;
};

}  // namespace pliant
