/// Comparing motions on one mesh, and across meshes that refine one another.
#pragma once

#include "model/model.hpp"

#include <array>
#include <vector>

namespace pliant {

/// Root mean square over all entries. Collective.
double nodal_mean_square(Vec x);

/// Root mean square length of a - b over the mass, over the nodes where the model has no mass [unit of a]. Collective.
double mean_square_distance(const Model& model, Vec a, Vec b);

/// What a motion is at the points of a sample, the same on every rank.
struct SampledState {
  std::vector<double> u, v;  ///< xyz per point
};

/// Quadrature points of a mesh, at which the mesh itself and finer ones are read. A mesh that is refined once more
/// shows to each cell's points what the one before showed to those of its own: the means of two such samples compare.
/// Points of a mesh coarser than both would not do: they lie at few places of the finer cells, which are special.
class Sample {
 public:
  /// The points of a rule of degree 5 in every cell. Collective.
  explicit Sample(const NodeLayout& layout);

  /// Displacement and velocity at the points, on this or another mesh of the same body. Collective.
  SampledState read(const NodeLayout& layout, Vec q, Vec v) const;

  /// Root mean square length of a - b over the volume. Not collective.
  double distance(const std::vector<double>& a, const std::vector<double>& b) const;

 private:
  std::vector<std::array<double, 3>> points_;
  std::vector<double> weights_;  // they sum to 1
};

}  // namespace pliant
