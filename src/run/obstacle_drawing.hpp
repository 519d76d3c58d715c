/// The obstacles as results show them: their surfaces as triangles, and the positions of these.
#pragma once

#include "io/obstacle_writer.hpp"
#include "model/contacts.hpp"

#include <vector>

namespace pliant {

class ObstacleDrawing {
 public:
  /// Unbounded obstacles are drawn around the bodies. `contacts` outlives the object. Collective.
  ObstacleDrawing(const Contacts& contacts, const NodeLayout& layout);

  /// The surfaces at their initial positions.
  const OutputObstacles& surfaces() const { return surfaces_; }
  /// Positions of the points [m]; empty if no obstacle moves.
  std::vector<double> points(const Instant& at) const;

 private:
  const Contacts& contacts_;
  OutputObstacles surfaces_;
  std::vector<std::size_t> end_of_points_;  // of each obstacle
};

}  // namespace pliant
