/// Preferred directions of a body, as the input describes them.
#pragma once

#include "input/cell_data.hpp"
#include "input/config.hpp"

#include <array>
#include <optional>

namespace pliant {

/// A direction as a function of the position.
class DirectionRule {
 public:
  /// `given` must outlive the object.
  explicit DirectionRule(const GivenDirection& given) : given_(given) {}

  const GivenDirection& given() const { return given_; }
  bool is_uniform() const;
  /// Finds its data on the mesh, which must outlive the object. Throws InputError.
  void bind(const CellData& data);
  /// The unit vector. Throws InputError if it has no direction.
  std::array<double, 3> at(PetscInt cell, const std::array<double, 3>& X) const;

 private:
  const GivenDirection& given_;
  const CellData* data_ = nullptr;
  std::size_t number_ = 0;  // of the data
};

/// The unit vector at right angles to `first` in the plane of both; nothing if they are parallel. Both are unit
/// vectors.
std::optional<std::array<double, 3>> across(const std::array<double, 3>& first, const std::array<double, 3>& second);

/// " at (x, y, z)".
std::string at_place(const std::array<double, 3>& X);

}  // namespace pliant
