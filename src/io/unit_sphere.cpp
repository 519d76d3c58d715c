#include "io/unit_sphere.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace pliant {

Sphere unit_sphere(int divisions) {
  Sphere sphere{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}}};
  for (int k = 0; k < divisions; ++k) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [found, is_new] = middles.insert({std::minmax(a, b), static_cast<std::int32_t>(sphere.points.size())});
      if (is_new) {
        const Vector3<double> sum =
            sphere.points[static_cast<std::size_t>(a)] + sphere.points[static_cast<std::size_t>(b)];
        sphere.points.push_back(unit(sum));
      }
      return found->second;
    };
    std::vector<std::array<std::int32_t, 3>> divided;
    for (const auto& [a, b, c] : sphere.triangles) {
      const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      divided.insert(divided.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    sphere.triangles = std::move(divided);
  }
  return sphere;
}

}  // namespace pliant
