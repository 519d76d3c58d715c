/// Which boxes overlap: a hierarchy of boxes over a curve that fills space.
///
/// Boxes are sorted by the Morton codes of their centres (Lauterbach et al. 2009, Fast BVH construction on GPUs), eight
/// that follow one another make a node, eight nodes one of the next level, up to a root. The tree is complete, so that
/// it needs no pointers, is refitted level by level, and compares a box with the eight of a node at once. The order of
/// equal codes is that of the boxes: the same boxes give the same tree.
#pragma once

#include "base/inline.hpp"
#include "collision/box.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// Numbers of two boxes that overlap.
struct BoxPair {
  std::int32_t first = 0, second = 0;
  friend auto operator<=>(const BoxPair&, const BoxPair&) = default;
};

class Bvh {
 public:
  static constexpr int width = 8;

  Bvh() = default;
  /// Builds the tree; costs a sort.
  explicit Bvh(std::span<const Box> boxes);

  /// Takes other boxes, as many, of what has moved a little: the order stays, and with it the tree's quality falls as
  /// neighbours part. The answers are always right.
  void refit(std::span<const Box> boxes);

  std::size_t size() const { return order_.size(); }

  /// f(number) of every box that overlaps this one, in no particular order.
  template <class F>
  void for_each_overlap(const Box& box, const F& f) const {
    visit(box, 0, f);
  }
  /// The same for the boxes from the given place of the order on, and perhaps some before it.
  template <class F>
  void for_each_overlap_from(std::size_t place, const Box& box, const F& f) const {
    visit(box, static_cast<std::int32_t>(place / width), f);
  }

  /// Boxes in the order of the tree, neighbours next to each other.
  std::span<const std::int32_t> order() const { return order_; }

 private:
  /// Eight boxes, coordinate by coordinate; absent ones hold nothing.
  struct alignas(32) Node {
    float low[3][width], high[3][width];
  };

  /// The same for the lowest nodes from `first` on.
  template <class F>
  void visit(const Box& box, std::int32_t first, const F& f) const;
  void set_leaves(std::span<const Box> boxes);
  void set_parents();

  std::vector<std::int32_t> order_;        ///< the number of each leaf's box
  std::vector<Node> nodes_;                ///< levels from the leaves' up to the root
  std::vector<std::int32_t> level_begin_;  ///< in nodes_, and its size behind the last
};

/// All pairs (i, j) of box i of `boxes` and box j of the tree that overlap and that accept(i, j) takes, sorted.
template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, std::span<const Box> boxes, std::span<const std::int32_t> order,
                                       const Accept& accept);

/// All pairs i < j of boxes of the tree, `boxes` being those it was built or refitted with, sorted.
template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, std::span<const Box> boxes, const Accept& accept);

/// Sorts pairs whose first numbers are below `num_first`, by counting.
void sort_pairs(std::vector<BoxPair>& pairs, std::size_t num_first);

// ---------------------------------------------------------------------------------------------------------------------

template <class F>
void Bvh::visit(const Box& box, std::int32_t first, const F& f) const {
  if (nodes_.empty()) return;
  struct Visit {
    std::int32_t level, node;  // the node's number within its level
  };
  // A node leaves at most 7 more on the stack than it takes, and there are at most 11 levels.
  std::array<Visit, 11 * width> stack;
  int top = 0;
  stack[top++] = {static_cast<std::int32_t>(level_begin_.size()) - 2, 0};
  while (top > 0) {
    const Visit at = stack[--top];
    const Node& node = nodes_[level_begin_[at.level] + at.node];
    std::array<std::int32_t, width> hits;
    for (int k = 0; k < width; ++k) {
      hits[k] = (node.low[0][k] <= box.high[0]) & (node.high[0][k] >= box.low[0]) & (node.low[1][k] <= box.high[1]) &
                (node.high[1][k] >= box.low[1]) & (node.low[2][k] <= box.high[2]) & (node.high[2][k] >= box.low[2]);
    }
    if (at.level == 0) {
      for (int k = 0; k < width; ++k) {
        if (hits[k] != 0) f(order_[width * at.node + k]);
      }
    } else {
      for (int k = 0; k < width; ++k) {
        const std::int32_t child = width * at.node + k;
        stack[top] = {at.level - 1, child};
        top += hits[k] & (child >= first >> (3 * (at.level - 1)));  // width^(level - 1) lowest nodes each
      }
    }
  }
}

template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, std::span<const Box> boxes, std::span<const std::int32_t> order,
                                       const Accept& accept) {
  std::vector<BoxPair> pairs;
  for (const std::int32_t i : order) {
    tree.for_each_overlap(boxes[i], [&](std::int32_t j) {
      if (accept(i, j)) pairs.push_back({i, j});
    });
  }
  sort_pairs(pairs, boxes.size());
  return pairs;
}

template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, std::span<const Box> boxes, const Accept& accept) {
  // Each pair once, from the one that comes first in the order.
  std::vector<std::int32_t> place(boxes.size());
  for (std::size_t n = 0; n < boxes.size(); ++n) place[tree.order()[n]] = static_cast<std::int32_t>(n);
  std::vector<BoxPair> pairs;
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    const std::int32_t i = tree.order()[n];
    tree.for_each_overlap_from(n, boxes[i], [&](std::int32_t j) {
      if (place[j] <= static_cast<std::int32_t>(n)) return;
      const BoxPair pair = i < j ? BoxPair{i, j} : BoxPair{j, i};
      if (accept(pair.first, pair.second)) pairs.push_back(pair);
    });
  }
  sort_pairs(pairs, boxes.size());
  return pairs;
}

}  // namespace pliant
