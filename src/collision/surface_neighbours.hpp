/// Parts of thin bodies that hang together and are too near each other along the surface to be kept apart: the next
/// segments of a rod that is thicker than they are long, or the body that a rod ends in. Rank-local.
#pragma once

#include "collision/surface.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace pliant {

class SurfaceNeighbours {
 public:
  SurfaceNeighbours() = default;
  /// `distances`: for each two bodies, by rows, how far along edges at rest neighbours are from each other at the most
  /// [m]; 0: they have none. The surface outlives the object.
  SurfaceNeighbours(const CollisionSurface& surface, int num_bodies, std::vector<double> distances);

  bool empty() const { return lists_.empty(); }
  /// Whether one of these vertices is a neighbour of one of the others.
  bool include(std::span<const std::int32_t> vertices, std::span<const std::int32_t> others) const {
    return !lists_.empty() && find(vertices, others);
  }

 private:
  bool find(std::span<const std::int32_t> vertices, std::span<const std::int32_t> others) const;

  std::vector<std::int32_t> begins_, lists_;  // of each vertex, ascending
};

}  // namespace pliant
