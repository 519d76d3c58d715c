#include "mesh/chamber_walls.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace pliant {
namespace {

/// From what the orientation of a part of a surface is known.
enum class Known { no, from_bodies, from_volume };

/// Solid angle of the triangle seen from the origin (Van Oosterom & Strackee 1983, "The solid angle of a plane
/// triangle", eq. 8).
double solid_angle(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c) {
  const double la = norm(a), lb = norm(b), lc = norm(c);
  return 2.0 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(a, c) * lb + dot(b, c) * la);
}

class Walls {
 public:
  Walls(std::vector<WallTriangle>& triangles, std::span<const char> is_of_body, const PlaceOfNode& place)
      : triangles_(triangles), is_of_body_(is_of_body), place_(place) {}

  std::vector<char> orient_all() {
    const std::vector<WallTriangle> given = triangles_;
    const std::vector<OrientedPart> parts = orient(triangles_);
    std::vector<Known> known;
    for (const OrientedPart& part : parts) known.push_back(orient_by_itself(part, given));
    std::vector<char> is_known(triangles_.size(), 0);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (known[p] == Known::no) {
        for (const std::size_t t : parts[p].triangles) triangles_[t] = given[t];
        continue;
      }
      if (known[p] == Known::from_volume && num_around(parts[p], parts) % 2 == 1) turn_over(parts[p]);
      for (const std::size_t t : parts[p].triangles) is_known[t] = 1;
    }
    return is_known;
  }

 private:
  Known orient_by_itself(const OrientedPart& part, std::span<const WallTriangle> given) {
    bool stays = false, turns = false;
    for (const std::size_t t : part.triangles) {
      if (is_of_body_[t] != 0) (triangles_[t] == given[t] ? stays : turns) = true;
    }
    if (stays && turns) return Known::no;
    if (turns) turn_over(part);
    if (stays || turns) return Known::from_bodies;
    if (!part.is_closed) return Known::no;
    if (volume_behind(triangles_, part.triangles, place_) > 0.0) turn_over(part);
    return Known::from_volume;
  }
  void turn_over(const OrientedPart& part) {
    for (const std::size_t t : part.triangles) std::swap(triangles_[t][1], triangles_[t][2]);
  }
  /// How many closed parts have this one in them.
  int num_around(const OrientedPart& part, std::span<const OrientedPart> parts) const {
    const Vector3<double> of = place_(triangles_[part.triangles.front()][0]);
    int result = 0;
    for (const OrientedPart& other : parts) {
      if (&other == &part || !other.is_closed) continue;
      double angle = 0.0;
      for (const std::size_t t : other.triangles) {
        const auto& [a, b, c] = triangles_[t];
        angle += solid_angle(place_(a) - of, place_(b) - of, place_(c) - of);
      }
      if (std::abs(angle) > 2.0 * std::numbers::pi) ++result;  // 4 pi inside, 0 outside
    }
    return result;
  }

  std::vector<WallTriangle>& triangles_;
  std::span<const char> is_of_body_;
  const PlaceOfNode& place_;
};

}  // namespace

double volume_behind(std::span<const WallTriangle> triangles, std::span<const std::size_t> part,
                     const PlaceOfNode& place) {
  double volume = 0.0;
  const Vector3<double> origin = place(triangles[part.front()][0]);
  for (const std::size_t t : part) {
    const auto& [a, b, c] = triangles[t];
    volume += dot(place(a) - origin, cross(place(b) - origin, place(c) - origin)) / 6.0;
  }
  return volume;
}

std::vector<char> orient_walls(std::vector<WallTriangle>& triangles, std::span<const char> is_of_body,
                               const PlaceOfNode& place) {
  return Walls(triangles, is_of_body, place).orient_all();
}

}  // namespace pliant
