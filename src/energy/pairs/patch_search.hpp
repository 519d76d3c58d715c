/// Which patches of all ranks are near one another (energy/coupling.hpp).
#pragma once

#include "energy/coupling.hpp"
#include "fem/layout.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// A box with sides along the axes [m].
struct Box {
  std::array<double, 3> low, high;

  static Box empty();
  void include(const Vector3<double>& x);
  void include(const Box& other);
  /// Moves all sides outwards.
  void grow(double by);
  bool contains(const Box& other) const;
  bool overlaps(const Box& other) const;
};

/// What a search leaves: this rank's patches, then those of other ranks that are near one of them.
struct FoundPatches {
  std::vector<std::int64_t> keys;
  std::vector<int> tags;
  std::vector<PetscInt> global_nodes;  ///< of the patches of other ranks
  std::vector<PatchPair> pairs;        ///< NearPatches::pairs
};

/// Finds the pairs of one coupling. What it finds holds as long as every patch stays within the box in which it was
/// looked for: its own, grown by half of the reach and by a skin that follows how far patches travel between searches.
class PatchSearch {
 public:
  /// Both outlive the object.
  PatchSearch(const NodeLayout& layout, const PairCoupling& coupling);

  /// Whether the last search holds on the straight way from q to q + d on this rank. Not collective.
  /// `d` may be empty. The arrays span the nodes of the layout at least.
  bool covers(std::span<const double> q, std::span<const double> d) const;
  /// Searches anew, for that way and what is near it. Collective.
  FoundPatches search(std::span<const double> q, std::span<const double> d);

 private:
  /// What the patch sweeps, grown by half of the reach.
  Box box_of(std::size_t patch, std::span<const double> q, std::span<const double> d) const;
  /// The patches of other ranks that may be near one of this rank, with their boxes.
  struct Received {
    std::vector<std::int64_t> numbers;  // key, tag, global nodes of each
    std::vector<Box> boxes;
  };
  Received exchange() const;

  const NodeLayout& layout_;
  const PairCoupling& coupling_;
  std::vector<Box> searched_;  // of each patch; empty before the first search
  double skin_;                // [m]
};

}  // namespace pliant
