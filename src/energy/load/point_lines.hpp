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

/// The line between two points: d = at_rest + sum_a w_a u_a leads from the first to the second, so that small
/// displacements keep their digits.
struct PointLine {
  std::size_t number = 0;       ///< of the pair
  std::vector<PetscInt> nodes;  ///< local ones, some of them perhaps twice
  std::vector<double> weights;  ///< of each
  Vector3<double> at_rest{};    ///< d in the reference configuration; 0 if that is rounding [m]
  bool is_counted = false;      ///< exactly one rank counts what is summed over pairs

  /// d at displacements q [m].
  Vector3<double> way(std::span<const double> q) const { return at_rest + change(q, {}); }
  /// d(q) - d(from), with the digits of small changes [m]; an empty `from`: the reference configuration.
  Vector3<double> change(std::span<const double> q, std::span<const double> from) const;
  /// |d(q)| - |d(from)|, likewise.
  double lengthening(std::span<const double> q, std::span<const double> from) const;
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

/// A line from one point to another.
class LineMaker {
 public:
  explicit LineMaker(const NearPatches& near) : near_(near) {}
  /// An end in space; `sign`: -1 of the first, 1 of the second.
  void add_fixed(double sign, const Vector3<double>& place) { add_place(sign, place); }
  /// An end at a point with these nodes.
  void add_end(double sign, std::span<const PetscInt> nodes, std::span<const double> weights);
  PointLine take(std::size_t number, bool is_counted) &&;

 private:
  void add_place(double weight, const Vector3<double>& place);

  const NearPatches& near_;
  PointLine line_;
  double size_ = 0.0;  // of the summands of at_rest [m]
};

/// Pairs of points as patches: the points 2 n and 2 n + 1 are those of the pair n.
class PointLines {
 public:
  /// Two points for each pair, the same number on every rank. Collective.
  PointLines(const NodeLayout& layout, std::span<const AttachedPoint> points);

  const Patches& patches() const { return patches_; }
  /// The points of those of which one has a node of this rank.
  const FixedPairs& fixed_pairs() const { return fixed_pairs_; }
  /// Pairs in which this rank sees both points; all of those with a node of its own.
  std::vector<PointLine> seen(const NearPatches& near) const;

 private:
  NodesOfPoints points_;
  Patches patches_;  // of the points that move
  FixedPairs fixed_pairs_;
  std::vector<Vector3<double>> fixed_;  // of each point in space [m]
};

}  // namespace pliant
