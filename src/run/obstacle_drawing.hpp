/// How results show obstacles: their surfaces as triangles, and where these are.
#pragma once

#include "io/obstacle_writer.hpp"
#include "model/contacts.hpp"

#include <vector>

namespace pliant {

class ObstacleDrawing {
 public:
  /// What is unbounded is drawn around the bodies. `contacts` outlives the object. Collective.
  ObstacleDrawing(const Contacts& contacts, const NodeLayout& layout);

  /// As if they did not move.
  const OutputObstacles& surfaces() const { return surfaces_; }
  /// Where the points are [m]; empty if no obstacle moves.
  std::vector<double> points(const Instant& at) const;

 private:
  const Contacts& contacts_;
  OutputObstacles surfaces_;
  std::vector<std::size_t> end_of_points_;  // of each obstacle
};

}  // namespace pliant
