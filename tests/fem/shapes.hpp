/// Every shape that an obstacle may have, for tests that run over all of them.
#pragma once

#include "fem/signed_distance.hpp"

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace pliant::test {

/// Below the unit cube, whose bottom is partly within.
struct ShapeCase {
  std::string name;
  std::function<std::unique_ptr<SignedDistance>()> make;
  bool is_hollow = false;
};

inline std::ostream& operator<<(std::ostream& out, const ShapeCase& c) {
  return out << c.name;
}

inline std::vector<ShapeCase> every_shape() {
  const Vector3<double> tilted{2.0 / 7, -3.0 / 7, 6.0 / 7}, lying{0.8, 0.6, 0.0};
  std::vector<ShapeCase> cases{
      {"Plane",
       [=] {
         return make_distance(PlaneShape{{0.5, 0.5, 0.1}, tilted});
       }},
      {"Sphere",
       [] {
         return make_distance(SphereShape{{0.4, 0.6, -0.8}, 1.0});
       }},
      {"Cylinder",
       [=] {
         return make_distance(CylinderShape{{0.5, 0.4, -0.5}, lying, 0.7});
       }},
      {"CylinderWithEnds",
       [=] {
         return make_distance(CylinderShape{{0.5, 0.4, -0.5}, tilted, 0.45, 1.2});
       }},
      {"Capsule",
       [=] {
         return make_distance(CapsuleShape{{0.5, 0.4, -0.5}, lying, 0.65, 0.5});
       }},
      {"Box",
       [] {
         return make_distance(BoxShape{{0.5, 0.45, -0.6}, {0.8, 0.7, 1.4}});
       }},
  };
  const std::size_t num_solids = cases.size();
  for (std::size_t k = 0; k < num_solids; ++k) {
    cases.push_back({"Hollow" + cases[k].name, [make = cases[k].make] { return hollow(make()); }, true});
  }
  return cases;
}

}  // namespace pliant::test
