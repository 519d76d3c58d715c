// Distances to surfaces of triangles, from files and made here: those of a box in closed form, signs around a notch.
#include "base/error.hpp"
#include "fem/surface_distance.hpp"
#include "mesh/scratch.hpp"
#include "petsc/collective.hpp"

#include <cmath>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

namespace pliant::test_surface_distance {
namespace {

using test::Scratch;

const MPI_Comm comm = MPI_COMM_WORLD;
using Triangles = std::vector<TrianglePatch>;

std::string stl(const Triangles& triangles) {
  std::ostringstream text;
  text << "solid part\n";
  for (const auto& triangle : triangles) {
    text << "facet normal 0 0 0\nouter loop\n";
    for (const auto& x : triangle) text << "vertex " << x[0] << ' ' << x[1] << ' ' << x[2] << '\n';
    text << "endloop\nendfacet\n";
  }
  text << "endsolid part\n";
  return text.str();
}

Triangles box(const Vector3<double>& center, const Vector3<double>& size) {
  return make_distance(BoxShape{center, size})->drawing({}, 0.0);
}

SurfaceMesh read(const Triangles& triangles, double scale = 1.0) {
  const Scratch scratch(comm);
  return read_surface(comm, {scratch.text("part.stl", stl(triangles)), {"in.yaml", 3, 4}, {}, scale});
}

std::vector<Vector3<double>> points(double extent) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-extent, extent);
  std::vector<Vector3<double>> result(1000);
  for (auto& x : result) x = {uniform(random), uniform(random), uniform(random)};
  return result;
}

// STL files that a reader makes of the box: four triangles meet at some corners, five at others, and some edges are
// diagonals of flat faces.
TEST(SurfaceDistance, OfABoxIsThatOfTheBox) {
  const BoxShape shape{{0.25, 0.0, -0.5}, {1.0, 2.0, 0.5}};
  const auto expected = make_distance(shape), found = make_distance(read(box(shape.center, shape.size)));
  int num_inside = 0;
  for (const auto& x : points(1.6)) {
    const DistanceAt a = expected->at(x), b = found->at(x);
    num_inside += a.d < 0.0 ? 1 : 0;
    EXPECT_NEAR(b.d, a.d, 1e-14);
    EXPECT_NEAR(found->distance(x), a.d, 1e-14);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(b.n[i], a.n[i], 1e-12);
    for (std::size_t i = 0; i < 9; ++i) {
      EXPECT_NEAR(b.curvature.a[i], a.curvature.a[i], 1e-10 * (1.0 + std::abs(trace(a.curvature))));
    }
  }
  EXPECT_GT(num_inside, 10);
}

// A box of 2 with a notch of 1 cut from its edge: a point in the notch is outside, whatever is nearest.
TEST(SurfaceDistance, KnowsTheSidesOfAReentrantEdge) {
  // An L in the plane, counterclockwise, between z = -1 and 1.
  const std::vector<std::array<double, 2>> L{{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}};
  Triangles triangles;
  const auto at = [&](std::size_t k, double z) { return Vector3<double>{L[k % 6][0], L[k % 6][1], z}; };
  for (std::size_t k = 0; k < 6; ++k) {
    triangles.push_back({at(k, -1), at(k + 1, -1), at(k + 1, 1)});
    triangles.push_back({at(k, -1), at(k + 1, 1), at(k, 1)});
  }
  for (const auto& [a, b, c] : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    triangles.push_back({at(a, 1), at(b, 1), at(c, 1)});
    triangles.push_back({at(a, -1), at(c, -1), at(b, -1)});
  }
  // Turned inside out, it is turned back.
  for (auto& triangle : triangles) std::swap(triangle[1], triangle[2]);
  const auto distance = make_distance(read(triangles));
  int num_inside = 0, num_in_notch = 0;
  for (const auto& x : points(1.3)) {
    const bool in_box = std::abs(x[0]) < 1 && std::abs(x[1]) < 1 && std::abs(x[2])<1, in_notch = x[0]> 0 && x[1] > 0;
    EXPECT_EQ(distance->distance(x) < 0.0, in_box && !in_notch);
    num_inside += in_box && !in_notch ? 1 : 0;
    num_in_notch += in_box && in_notch ? 1 : 0;
    const DistanceAt here = distance->at(x);
    constexpr double h = 1e-6;
    for (std::size_t i = 0; i < 3; ++i) {
      auto ahead = x, behind = x;
      ahead[i] += h;
      behind[i] -= h;
      EXPECT_NEAR((distance->distance(ahead) - distance->distance(behind)) / (2.0 * h), here.n[i], 1e-8);
    }
  }
  EXPECT_GT(num_inside, 100);
  EXPECT_GT(num_in_notch, 30);
  EXPECT_NEAR(distance->distance({0.3, 0.4, 0.0}), 0.3, 1e-14);
  EXPECT_NEAR(distance->distance({-0.3, -0.4, 0.0}), -0.5, 1e-14);  // from the reentrant edge
}

TEST(SurfaceDistance, IsScaledAndTheSameOnEveryRank) {
  const SurfaceMesh surface = read(box({}, {2.0, 2.0, 2.0}), 0.5);
  EXPECT_EQ(surface.nodes.size(), 8U);
  EXPECT_EQ(surface.triangles.size(), 12U);
  EXPECT_DOUBLE_EQ(make_distance(surface)->distance({0.0, 0.0, 1.5}), 1.0);
  EXPECT_EQ(maximum(comm, surface.nodes[3][1]), minimum(comm, surface.nodes[3][1]));
}

std::string mistake(const Triangles& triangles) {
  try {
    read(triangles);
  } catch (const InputError& error) {
    return to_string(error.diagnostics().front().where) + ": " + error.diagnostics().front().message;
  }
  return "";
}

TEST(SurfaceDistance, IsRefusedWhereItEnclosesNothing) {
  Triangles open = box({}, {1.0, 1.0, 1.0});
  open.pop_back();
  EXPECT_NE(mistake(open).find("not closed: 3 edges"), std::string::npos) << mistake(open);
  Triangles flat;  // a tetrahedron with its four corners in a plane
  const std::array<Vector3<double>, 4> square{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}};
  for (const auto& [a, b, c] : std::vector<std::array<std::size_t, 3>>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
    flat.push_back({square[a], square[b], square[c]});
  EXPECT_NE(mistake(flat).find("encloses no volume"), std::string::npos) << mistake(flat);
  EXPECT_EQ(mistake(open).find("in.yaml:3:4"), 0U);
  Triangles turned = box({}, {1.0, 1.0, 1.0});
  std::swap(turned[4][0], turned[4][1]);
  EXPECT_NE(mistake(turned).find("opposite sides"), std::string::npos) << mistake(turned);
}

}  // namespace
}  // namespace pliant::test_surface_distance
