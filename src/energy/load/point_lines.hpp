/// Points that are fixed in bodies or in space, and the lines between two of them: of springs, on any ranks.
#pragma once

#include "base/vector3.hpp"
#include "energy/coupling.hpp"
#include "fem/layout.hpp"
#include "fem/probe.hpp"

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// A place that moves with the nodes of a cell, or not at all.
struct AttachedPoint {
  ProbeLocation location;                ///< its weights add up to 1; one rank has the nodes
  std::optional<Vector3<double>> fixed;  ///< a place in space instead [m]
};

/// The line between two points: d = offset + sum_a w_a x_a leads from the first to the second.
struct PointLine {
  std::size_t number = 0;       ///< of the pair
  std::vector<PetscInt> nodes;  ///< local ones, some of them perhaps twice
  std::vector<double> weights;  ///< of each
  Vector3<double> offset{};     ///< of points in space [m]
  bool is_counted = false;      ///< exactly one rank counts what is summed over pairs

  /// d at displacements q [m].
  Vector3<double> way(const NearPatches& near, std::span<const double> q) const;
  /// d(q) - d(from), with the digits of small changes [m]; an empty `from`: the reference configuration.
  Vector3<double> change(std::span<const double> q, std::span<const double> from) const;
  /// |d(q)| - |d(from)|, likewise.
  double lengthening(const NearPatches& near, std::span<const double> q, std::span<const double> from) const;
  /// r += w_a f in the rows of owned nodes.
  void add_force(const NearPatches& near, const Vector3<double>& f, std::span<double> r) const;
  /// K += w_a w_b block in the rows of owned nodes.
  void add_stiffness(const NearPatches& near, const std::array<double, 9>& block, const BlockWriter& K) const;
};

/// The nodes of points, by their global numbers, and their weights: the same on every rank. A point in space has none.
struct NodesOfPoints {
  std::vector<std::vector<PetscInt>> nodes;
  std::vector<std::vector<double>> weights;
};
/// Collective.
NodesOfPoints nodes_of_points(const NodeLayout& layout, std::span<const AttachedPoint> points);

/// The points that have nodes as patches with their numbers as keys, on the ranks that own one of their nodes; weights
/// are filled up with zeros to the size of a patch. Not collective.
Patches patches_of_points(const NodeLayout& layout, NodesOfPoints& points,
                          const std::function<int(std::size_t)>& tag_of);

/// Adds an end of a line, a point with these nodes; `sign`: -1 of the first, 1 of the second.
void add_end(double sign, std::span<const PetscInt> nodes, std::span<const double> weights, PointLine& line);

/// Pairs of points as patches: the points 2 n and 2 n + 1 are those of the pair n.
class PointLines {
 public:
  /// Two points for each pair, the same number on every rank. Collective.
  PointLines(const NodeLayout& layout, std::span<const AttachedPoint> points);

  const Patches& patches() const { return patches_; }
  /// Pairs in which this rank sees both points; all of those with a node of its own.
  std::vector<PointLine> seen(const NearPatches& near) const;

 private:
  NodesOfPoints points_;
  Patches patches_;                     // of the points that move
  std::vector<Vector3<double>> fixed_;  // of each point in space [m]
};

}  // namespace pliant
