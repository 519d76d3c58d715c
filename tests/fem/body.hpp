/// Small bodies for the tests of the layers above the mesh: unit cubes of Kuhn tetrahedra, straight, jittered or
/// curved.
#pragma once

#include "fem/block_matrix.hpp"
#include "fem/layout.hpp"
#include "mesh/box_mesh.hpp"
#include "mesh/plex_points.hpp"
#include "mesh/scratch.hpp"

#include <array>
#include <cmath>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test {

using Point = std::array<double, 3>;

enum class Shape {
  straight,
  jittered,  ///< vertices out of place, those of a face within it
  curved     ///< second-order geometry: `bent` of the cube
};

/// Moves points of the unit cube, of no two alike; faces, edges and corners stay where they are as sets.
inline Point jittered(Point x) {
  Point y = x;
  for (int i = 0; i < 3; ++i) {
    y[i] += 0.25 * x[i] * (1.0 - x[i]) * std::sin(41.0 * x[0] + 67.0 * x[1] + 89.0 * x[2] + 2.0 * i);
  }
  return y;
}

/// A quadratic map, which isoparametric P2 cells follow exactly; det = 1 - .04 x z + .004 x^2 y - .01 y^2.
inline Point bent(Point x) {
  return {x[0] + 0.1 * x[1] * x[2], x[1] + 0.2 * x[0] * x[0], x[2] + 0.1 * x[0] * x[1]};
}
inline constexpr double bent_volume = 1.0 - 0.04 / 4.0 + 0.004 / 6.0 - 0.01 / 3.0;

struct BodySpec {
  int order = 1;  ///< of the displacement
  Shape shape = Shape::straight;
  int n = 2;  ///< cubes along each edge
  int geometry_order() const { return shape == Shape::curved ? 2 : 1; }
  double volume() const { return shape == Shape::curved ? bent_volume : 1.0; }
};

inline std::ostream& operator<<(std::ostream& out, const BodySpec& spec) {
  constexpr std::array names{"Straight", "Jittered", "Curved"};
  return out << "P" << spec.order << names[static_cast<std::size_t>(spec.shape)] << spec.n;
}

/// For the names of parametrised tests.
inline std::string name_of(const BodySpec& spec) {
  std::ostringstream text;
  text << spec;
  return text.str();
}

inline void write_body(const std::string& file, const BodySpec& spec) {
  BoxOptions options;
  options.order = spec.geometry_order();
  options.outline = Outline::edge_and_corner;
  if (spec.shape == Shape::jittered) options.map = jittered;
  if (spec.shape == Shape::curved) options.map = bent;
  write_box_msh(file, {1.0, 1.0, 1.0}, {spec.n, spec.n, spec.n}, options);
}

inline Mesh read_file(MPI_Comm comm, const std::string& file) {
  MeshSource source;
  source.file = file;
  return read_mesh(comm, source);
}

/// Mesh, unknowns and matrix pattern. On MPI_COMM_SELF every rank has the whole body for itself, as a run on one rank.
struct Body {
  Body(MPI_Comm comm, const std::string& file, int order)
      : mesh(read_file(comm, file)), layout(make_layout(mesh, order)), pattern(layout) {}
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  Mesh mesh;
  NodeLayout layout;
  BlockPattern pattern;
};

/// Tests on bodies of several kinds.
class OnBodies : public ::testing::TestWithParam<BodySpec> {
 protected:
  Scratch scratch_{MPI_COMM_WORLD};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) { write_body(f, GetParam()); });
  Body body_{MPI_COMM_WORLD, file_, GetParam().order};
  const NodeLayout& layout_ = body_.layout;
};

/// Values that depend on the place and the seed alone, so that they are the same on every number of ranks; rough from
/// node to node, in (-1, 1).
inline double rough(const Point& x, int component, int seed) {
  return std::sin(53.0 * x[0] + 91.0 * x[1] + 37.0 * x[2] + 1.7 * component + 2.9 * seed);
}

/// The group of that name. Throws if there is none.
inline const PhysicalGroup& group_named(const Mesh& mesh, const std::string& name) {
  for (const auto& group : mesh.groups) {
    if (group.name == name) return group;
  }
  throw std::runtime_error("no group " + name);
}

}  // namespace pliant::test
