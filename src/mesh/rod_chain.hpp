/// Rods as chains of tetrahedra: the places of their nodes.
#pragma once

#include "mesh/mesh.hpp"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Corners of a tetrahedron of positive volume [m].
using CornerPlaces = std::array<std::array<double, 3>, 4>;

/// A rod with the points x_0 .. x_n. Segment i has a frame, its direction t and the directors d_1 and d_2 of its
/// section, and is the tetrahedron x_i, x_{i+1}, m + a_1 d_1, m + a_2 d_2 with the middle m. A section at an end that
/// is held is a tetrahedron, too, with the frame of the segment there: x, the point half a segment beyond, x + a_1 d_1,
/// x + a_2 d_2, the first two in their order along the rod.
struct RodChain {
  std::vector<CornerPlaces> segments;
  std::array<std::optional<CornerPlaces>, 2> ends;  ///< at the first and at the last point
  std::string fault;                                ///< why it cannot be, as words that follow its name; empty: it can
};

/// d_1 follows `up` where that is given. Else it has any direction at the first segment and is transported in parallel
/// from there: the frames do not twist. `points`: at least two.
RodChain rod_chain(const AddedRod& rod, std::span<const std::array<double, 3>> points);

/// The points of a rod: its own, or those along its curve among `curves`. Throws InputError at the rod's place if the
/// curve is not there, or not one line.
std::vector<std::array<double, 3>> points_of(const AddedRod& rod, std::span<const MeshCurve> curves);

/// The points of all rods. A point of a rod that has its own is moved onto one of a curve's rod or of a rod before, by
/// which it lies up to rounding: the two are one. Throws InputError as points_of does.
std::vector<std::vector<std::array<double, 3>>> joined_points_of(std::span<const AddedRod> rods,
                                                                 std::span<const MeshCurve> curves);

/// The name of the volume of a section at an end; `end`: 0 the first, 1 the last.
std::string name_of_end(const std::string& rod, std::size_t end);

}  // namespace pliant
