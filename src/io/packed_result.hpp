/// A result compressed for a page: the surfaces of its bodies, some of its frames, quantised values.
#pragma once

#include "io/packed_companions.hpp"
#include "mesh/report.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pliant {

/// A surface (io/body_surface.hpp); texts are those of packed_text and PackedRows.
struct PackedMesh {
  std::size_t num_vertices = 0;
  std::size_t num_triangles = 0;
  int triangles_per_facet = 1;
  std::string triangles;                 ///< one row: differences of consecutive vertex numbers as int32
  std::string bodies;                    ///< of each vertex, int32
  std::array<std::string, 3> positions;  ///< reference positions, one row each
  std::array<Quantisation, 3> scales;    ///< of the positions [m]
};

struct PackedFrame {
  double time = 0.0;  ///< [s]; the load factor in a static problem
  std::int64_t step = 0;
  std::size_t mesh = 0;
  std::array<double, 3> shift{};  ///< mean displacement, which the packed displacement is relative to [m]
  std::string label;              ///< ResultFrame::label
};

/// Values at vertices; a row per frame.
struct PackedField {
  std::string name;
  std::string unit;
  std::vector<Quantisation> scales;              ///< of each component
  std::vector<std::vector<std::string>> values;  ///< by mesh and component
  /// Numbers of bodies that do not have it, as rigid ones have no stress: it is 0 there in all frames.
  std::vector<int> absent;
};

struct PackedResult {
  std::vector<std::string> body_names;
  std::vector<std::string> unseen_bodies;  ///< those of body_names that are not drawn
  std::vector<std::string> masses;         ///< those that are drawn as ellipsoids of inertia
  std::size_t num_nodes = 0;               ///< of the last mesh
  ElementCounts elements;                  ///< likewise
  int nodes_per_cell = 4;
  std::size_t num_frames = 0;  ///< of the result, before it was thinned
  std::vector<PackedMesh> meshes;
  std::vector<PackedObstacles> obstacles;    ///< for each mesh
  std::vector<PackedMechanisms> mechanisms;  ///< for each mesh
  std::vector<PackedFrame> frames;
  std::vector<PackedField> fields;  ///< the displacement, if there is one, first

  std::size_t size() const;  ///< an upper bound of its size in a page, and close to it [bytes]
};

/// Leaves out frames, evenly, until size() is at most `most_bytes`, but keeps the first and the last. Tensors are
/// reduced to their invariants (von Mises, mean); frames whose displacement is not finite are left out. FileError if
/// there is no frame.
PackedResult pack_result(const ResultReader& result, std::size_t most_bytes);

}  // namespace pliant
