/// The triangles of a thin layer on all ranks, and which of them are neighbours.
#pragma once

#include "base/vector3.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace pliant {

/// An edge by its global nodes, the lower one first, about which a layer does not turn, and the plane of symmetry that
/// it lies in, if it is one.
struct ClampedEdge {
  std::array<std::int64_t, 2> nodes{};
  std::array<double, 3> normal{};
  char has_normal = 0;
  std::int32_t source = 0;  ///< which of the user's curves it is from
};

/// Built the same on every rank.
class ShellTopology {
 public:
  using Triangle = std::array<std::int64_t, 3>;  ///< global nodes

  /// A side of a triangle: from its corner k to the next.
  struct Side {
    std::int64_t triangle = -1;
    std::size_t k = 0;
  };
  /// An edge that carries a moment: between two triangles, or clamped, with one.
  struct Edge {
    std::array<Side, 2> sides;
    bool is_oriented = true;  ///< both triangles have the same orientation there
    std::optional<ClampedEdge> clamped;
  };

  ShellTopology() = default;
  /// Neighbours get one orientation where the surface has one; that of the first triangle of each part stays.
  ShellTopology(std::vector<Triangle> triangles, std::span<const ClampedEdge> clamped);

  std::span<const Triangle> triangles() const { return triangles_; }
  std::span<const Edge> edges() const { return edges_; }
  /// The number of the edge at a side; -1: it carries no moment.
  std::int64_t edge_at(std::size_t triangle, std::size_t k) const { return edge_at_[triangle][k]; }
  /// What lies across a side; its triangle is -1 if there is none.
  Side across(std::size_t triangle, std::size_t k) const;
  /// Itself, its neighbours and theirs, ascending.
  std::vector<std::int64_t> patch(std::size_t triangle) const;
  /// Clamped edges that do not bound the layer, by their sources; none where all do.
  const std::map<std::int32_t, std::int64_t>& num_unclamped() const { return num_unclamped_; }

 private:
  using SidesOfEdges = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Side>>;
  SidesOfEdges sides_of_edges() const;

  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  std::vector<std::array<std::int64_t, 3>> edge_at_;
  std::map<std::int32_t, std::int64_t> num_unclamped_;
};

}  // namespace pliant
