#include "fem/plane.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr double plane_flatness = 1e-6;
constexpr double zero_component = 1e-9;

}  // namespace

std::optional<Vector3<double>> common_normal(const NodeLayout& layout, const FacetList& facets) {
  const auto corner = [&](PetscInt f, int a) { return layout.position(facets.nodes[f * facets.nodes_per_facet + a]); };
  Vector3<double> area{};
  for (PetscInt f = 0; f < facets.size(); ++f) {
    if (!facets.is_owned[f]) continue;
    const auto X = corner(f, 0);
    area = area + cross(corner(f, 1) - X, corner(f, 2) - X);
  }
  for (double& a : area) a = sum(layout.comm, a);
  const double size = std::sqrt(dot(area, area));
  if (size == 0.0) return std::nullopt;
  Vector3<double> n = (1.0 / size) * area;
  for (double& n_i : n) n_i = std::abs(n_i) < zero_component ? 0.0 : n_i;
  n = (1.0 / std::sqrt(dot(n, n))) * n;

  double low = std::numeric_limits<double>::infinity(), high = -low;
  Vector3<double> lower{low, low, low}, upper{high, high, high};
  for (const PetscInt node : facets.nodes) {
    const auto X = layout.position(node);
    low = std::min(low, dot(n, X));
    high = std::max(high, dot(n, X));
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], X[i]);
      upper[i] = std::max(upper[i], X[i]);
    }
  }
  double extent = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    extent = std::max(extent, maximum(layout.comm, upper[i]) - minimum(layout.comm, lower[i]));
  }
  const double height = maximum(layout.comm, high) - minimum(layout.comm, low);
  return height <= plane_flatness * extent ? std::optional(n) : std::nullopt;
}

}  // namespace pliant
