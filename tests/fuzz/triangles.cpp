#include "fem/surface_distance.hpp"
#include "fuzz/targets.hpp"
#include "mesh/serial_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>
#include <stdexcept>

namespace pliant::fuzz {
namespace {

constexpr std::size_t stl_header_size = 84, normal_size = 12, triangle_size = 50;  // of a binary STL file

std::vector<double> corners_in(std::string_view bytes) {
  std::vector<double> corners;
  for (std::size_t at = stl_header_size; at + triangle_size <= bytes.size(); at += triangle_size) {
    std::array<float, 9> x{};
    std::memcpy(x.data(), bytes.data() + at + normal_size, sizeof x);
    corners.insert(corners.end(), x.begin(), x.end());
  }
  return corners;
}

/// What a contact computes of the point.
void look_from(const SignedDistance& surface, const Vector3<double>& x) {
  const DistanceAt there = surface.at(x);
  for (const double number : {there.d, there.n[0], there.n[1], there.n[2], surface.distance(x)}) {
    if (!std::isfinite(number)) throw std::logic_error("a distance or its derivative is not finite");
  }
}

}  // namespace

void read_as_triangles(std::string_view bytes) {
  SurfaceMesh surface;
  try {
    surface = closed_surface(corners_in(bytes), 1.0);
  } catch (const MeshDefect&) {
    return;
  }
  const auto distance = make_distance(surface);
  const auto at = [&](PetscInt node) {
    const auto& x = surface.nodes[static_cast<std::size_t>(node)];
    return Vector3<double>{x[0], x[1], x[2]};
  };
  for (const auto& [a, b, c] : std::span(surface.triangles).first(std::min<std::size_t>(surface.triangles.size(), 8))) {
    const Vector3<double> ends[] = {at(a), at(b), at(c)};
    look_from(*distance, ends[0]);
    look_from(*distance, 0.5 * (ends[0] + ends[1]));
    look_from(*distance, (1.0 / 3.0) * (ends[0] + ends[1] + ends[2]));
    look_from(*distance, 3.0 * ends[0] + (-2.0) * ends[1]);
  }
}

}  // namespace pliant::fuzz
