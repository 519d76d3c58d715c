/// Data that the mesh file contains for its cells (elements).
#pragma once

#include "base/error.hpp"

#include <span>
#include <string>

#include <petscsys.h>

namespace pliant {

/// On the cells of this rank.
class CellData {
 public:
  virtual ~CellData() = default;

  /// The index of the data with this name. Throws InputError if there are none, or if they have other numbers of
  /// components.
  virtual std::size_t find(const std::string& name, int components, const Location& where) const = 0;
  /// The values on a local cell, NaN where the file has none.
  virtual std::span<const double> at(std::size_t data, PetscInt cell) const = 0;
  virtual const std::string& name(std::size_t data) const = 0;
};

}  // namespace pliant
