/// Compares motions on one mesh, and across meshes that refine one another.
#pragma once

#include "model/model.hpp"

#include <array>
#include <vector>

namespace pliant {

/// Root mean square over all entries. Collective.
double nodal_mean_square(Vec x);

/// Root mean square length of a - b over the mass, over the nodes where the model has no mass [unit of a]. Collective.
double mean_square_distance(const Model& model, Vec a, Vec b);

/// A motion at the points of a sample, the same on every rank.
struct SampledState {
  std::vector<double> u, v;  ///< xyz per point
};

/// Quadrature points of a mesh, at which motions on this mesh and on finer ones are evaluated. A mesh that is refined
/// once more sees the points of each cell as the previous mesh saw those of its own, so the means of two such samples
/// are comparable. Points of a mesh coarser than both would not do: they lie at few, special places of the finer cells.
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
