#include "collision/distance.hpp"

namespace pliant {

Stencil<2> point_point_stencil() {
  return {.weights = {1.0, -1.0}};
}

Stencil<3> stencil_of(const PointEdge& closest) {
  Stencil<3> stencil{.weights = {1.0, closest.s - 1.0, -closest.s}};
  if (closest.feature == EdgeFeature::inside) {
    stencil.num_slopes = 1;
    stencil.slopes[0] = {0.0, 1.0, -1.0};
  }
  return stencil;
}

Stencil<4> stencil_of(const PointTriangle& closest) {
  const auto& l = closest.barycentric;
  Stencil<4> stencil{.weights = {1.0, -l[0], -l[1], -l[2]}};
  if (closest.feature == TriangleFeature::face) {
    stencil.num_slopes = 2;
    stencil.slopes = {{{0.0, 1.0, -1.0, 0.0}, {0.0, 1.0, 0.0, -1.0}}};
  } else if (closest.feature >= TriangleFeature::edge_01) {
    const int edge = static_cast<int>(closest.feature) - static_cast<int>(TriangleFeature::edge_01);
    stencil.num_slopes = 1;
    stencil.slopes[0][1 + edge] = 1.0;
    stencil.slopes[0][1 + (edge + 1) % 3] = -1.0;
  }
  return stencil;
}

Stencil<4> stencil_of(const EdgeEdge& closest) {
  Stencil<4> stencil{.weights = {1.0 - closest.s, closest.s, closest.t - 1.0, -closest.t}};
  if (closest.a == EdgeFeature::inside) stencil.slopes[stencil.num_slopes++] = {-1.0, 1.0, 0.0, 0.0};
  if (closest.b == EdgeFeature::inside) stencil.slopes[stencil.num_slopes++] = {0.0, 0.0, 1.0, -1.0};
  return stencil;
}

}  // namespace pliant
