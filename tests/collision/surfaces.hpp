/// Surfaces for the tests.
#pragma once

#include "collision/surface.hpp"
#include "derivatives.hpp"

#include <utility>

namespace pliant::testing_collision {

struct SurfaceInput {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;

  CollisionSurface surface() const { return {vertices, triangles}; }
};

/// [0, 1]^2 at the height z in n x n squares of two triangles, diagonals at random, vertices inside moved by a part of
/// the square. Keys from `first_key` on.
inline SurfaceInput patch(int n, double z, VertexKey first_key, std::int32_t body, unsigned seed, double moved = 0.2) {
  SurfaceInput input;
  RandomPoints random(seed);
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      Vector3<double> X{double(i) / n, double(j) / n, z};
      if (i > 0 && i < n) X[0] += random.number(-moved, moved) / n;
      if (j > 0 && j < n) X[1] += random.number(-moved, moved) / n;
      input.vertices.push_back({first_key + (n + 1) * j + i, X});
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const VertexKey a = first_key + (n + 1) * j + i, b = a + 1, c = a + n + 2, d = a + n + 1;
      if (random.integer(0, 1) == 0) {
        input.triangles.push_back({{a, b, c}, body, 0});
        input.triangles.push_back({{a, c, d}, body, 0});
      } else {
        input.triangles.push_back({{a, b, d}, body, 0});
        input.triangles.push_back({{b, c, d}, body, 0});
      }
    }
  }
  return input;
}

inline SurfaceInput joined(SurfaceInput a, const SurfaceInput& b) {
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  a.triangles.insert(a.triangles.end(), b.triangles.begin(), b.triangles.end());
  return a;
}

/// The boundary of [0, 1]^3.
inline SurfaceInput cube() {
  SurfaceInput input;
  for (int n = 0; n < 8; ++n) {
    input.vertices.push_back({n, {double(n & 1), double(n >> 1 & 1), double(n >> 2 & 1)}});
  }
  for (const auto& [a, b, c, d] : std::vector<std::array<VertexKey, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    input.triangles.push_back({{a, b, c}, 0, 0});
    input.triangles.push_back({{a, c, d}, 0, 0});
  }
  return input;
}

}  // namespace pliant::testing_collision
