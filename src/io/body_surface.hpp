/// What is seen of a mesh: the surfaces of its bodies as triangles.
#pragma once

#include "io/result_writer.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// Triangles around every body, counterclockwise seen from outside. Each body has vertices of its own, so that values
/// may jump from one to the next, and so has each side of a sharp edge, so that averaged normals show it as one.
/// Vertices near in space are near in number. Bodies that are only masses are ellipsoids
/// (OutputMesh::masses), rods are prisms (io/rod_surface.hpp).
struct BodySurface {
  std::vector<std::int32_t> triangles;  ///< three vertices each
  int triangles_per_facet = 1;          ///< 1: corners of the facets; 4: also the middles of their edges
  std::vector<std::int64_t> nodes;      ///< of each vertex; of an ellipsoid's one of its corners
  std::vector<std::int32_t> bodies;     ///< of each vertex

  /// Weights that turn values of cells into values at vertices: averages over the cells of the body around the node,
  /// by reference volume; of vertex v the entries first[v] to first[v + 1].
  struct Averages {
    std::vector<std::size_t> first;
    std::vector<std::int64_t> cells;
    std::vector<double> weights;
  } averages;

  /// The vertices of ellipsoids and prisms, the last ones: values are weighted sums of those at four nodes.
  struct Blend {
    std::array<std::int64_t, 4> nodes;
    std::array<double, 4> weights;
  };
  std::vector<Blend> blends;

  std::size_t num_vertices() const { return nodes.size(); }
};

/// Where quadratic elements have more facets than `most_divided`, their facets count as flat. FileError if the mesh has
/// 2^31 nodes or more.
BodySurface surface_of_bodies(const OutputMesh& mesh, std::size_t most_divided = 60'000);

/// Components by vertex, of a field with components by node or by cell.
std::vector<double> at_vertices(const BodySurface& surface, std::span<const double> values, FieldLocation location,
                                int components);

}  // namespace pliant
