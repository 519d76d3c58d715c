/// The mean motion of a surface: where its middle is, and how it has turned.
#pragma once

#include "base/vector3.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <vector>

namespace pliant {

/// The part of a node in the mean motion of a surface.
struct NodeOfSurface {
  PetscInt node = 0;         ///< local, owned
  double share = 0.0;        ///< int N_a dA / A
  Vector3<double> moment{};  ///< int N_a (X - X_m) dA / A [m]
};

/// With these weights sum_a share_a x_a is the mean of x over the reference surface of area A, and
/// sum_a x_a moment_a^T the mean of x (X - X_m)^T, both exact for the element's shape functions. Forces share_a f are
/// those of a uniform traction, forces S moment_a those of the linear traction S (X - X_m) / A.
struct SurfaceMean {
  std::vector<NodeOfSurface> nodes;  ///< of this rank
  double area = 0.0;                 ///< A [m^2]
  Vector3<double> middle{};          ///< X_m [m]
  Tensor3<double> second_moment{};   ///< J = int (X - X_m) (X - X_m)^T dA / A [m^2]

  /// J_r = tr(J) I - J: the moment of a small rotation, int (X - X_m) x (theta x (X - X_m)) dA / A = J_r theta.
  Tensor3<double> rotational_moment() const { return add_to_diagonal(-1.0 * second_moment, trace(second_moment)); }
  /// Whether all of it lies on one line, about which it has no rotation; so does a point.
  bool is_line() const;
};

/// Collective.
SurfaceMean mean_of_surface(const NodeLayout& layout, const FacetList& facets);

}  // namespace pliant
