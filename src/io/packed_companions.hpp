/// Obstacles and mechanisms of a result, compressed for a page.
#pragma once

#include "io/packed.hpp"
#include "io/result_reader.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Rows of a value at each vertex, with the smallest scale that holds them, as PackedRows.
std::pair<std::string, Quantisation> packed_rows(const std::vector<std::vector<float>>& rows,
                                                 const EarlierNeighbours& neighbours);

/// Numbers `component`, `component` + 3, ... of points.
std::vector<float> component_of(std::span<const double> points, std::size_t component);

/// Differences of consecutive vertex numbers, as packed_text.
std::string packed_triangles(std::span<const std::int32_t> triangles);

/// Points where they are drawn in the reference configuration, and their displacement from there, a row per frame.
struct PackedPoints {
  std::size_t count = 0;
  std::array<std::string, 3> positions, moves;
  std::array<Quantisation, 3> position_scales, move_scales;  ///< [m]
};

/// The obstacles of a mesh, if there are any.
struct PackedObstacles {
  std::vector<std::string> names;
  PackedPoints points;
  std::string triangles;  ///< as packed_triangles
  std::string owners;     ///< index into names of each triangle, int32
};

/// Tendons, springs and joints of a mesh, if there are any (OutputMechanisms).
struct PackedMechanisms {
  std::vector<std::string> names, kinds;
  PackedPoints points;
  std::string segments;        ///< two point numbers each, int32
  std::string parts;           ///< index into names of each segment, int32
  std::string joints;          ///< point numbers, int32
  std::string tensions;        ///< of each segment, a row per frame
  Quantisation tension_scale;  ///< [N]
};

/// Calls `add` with every text that the page has of them.
using AddText = std::function<void(const std::string&)>;
void for_each_text(const PackedObstacles& obstacles, const AddText& add);
void for_each_text(const PackedMechanisms& mechanisms, const AddText& add);

/// The companions of a mesh, and where they are in the frames that have been read.
class Companions {
 public:
  struct Frame {
    std::vector<double> obstacle_moves, mechanism_moves;  // from the reference configuration [m]
    std::vector<double> tensions;                         // [N]
  };

  Companions() = default;
  /// `mesh`: ResultFrame::mesh.
  Companions(const ResultReader& result, const std::string& mesh);

  /// FileError if the frame does not have what the mesh has.
  Frame read(const ResultReader& result, const ResultFrame& frame) const;
  PackedObstacles obstacles(const std::vector<const Frame*>& frames) const;
  PackedMechanisms mechanisms(const std::vector<const Frame*>& frames) const;

 private:
  OutputObstacles given_obstacles_;
  OutputMechanisms given_mechanisms_;
  EarlierNeighbours obstacle_neighbours_, point_neighbours_, segment_neighbours_;
  PackedObstacles obstacles_;    // without what moves
  PackedMechanisms mechanisms_;  // without what moves
};

}  // namespace pliant
