/// How results show free shells: their cells as thin pyramids below their triangles.
#pragma once

#include "fem/apexes.hpp"
#include "input/config.hpp"
#include "model/model.hpp"

#include <span>
#include <vector>

namespace pliant {

/// Apexes have no motion of their own: results show them below the middles of their triangles, half of the thickness
/// away.
class ShellDrawing {
 public:
  /// `model` outlives the object. Not collective.
  ShellDrawing(const Config& config, const Model& model);

  /// Sets inert nodes of positions by those of their corners, xyz of local nodes [m].
  void place(std::span<double> positions) const;
  /// Sets inert nodes of displacements from the places in the result, xyz of local nodes [m].
  void displace(std::span<double> displacements) const;
  /// Sets inert nodes of another field of the nodes to means of their corners, `width` components of local nodes.
  void average(std::span<double> values, std::size_t width = 3) const;

 private:
  struct Shown {
    InertNode inert;
    double depth = 0.0;  // below the triangle [m]
  };
  const NodeLayout& layout_;
  std::vector<Shown> nodes_;
};

}  // namespace pliant
