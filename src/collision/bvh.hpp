/// Which boxes overlap: a hierarchy of boxes over a curve that fills space (bounding volume hierarchy, BVH).
///
/// Boxes are sorted by the Morton codes of their centres (Lauterbach et al. 2009, Fast BVH construction on GPUs), eight
/// that follow one another make a node, eight nodes one of the next level, up to a root. The tree is complete, so that
/// it needs no pointers, is refitted node by node, and compares a box with the eight of a node at once. Two trees, or a
/// tree and itself, are compared by groups: the eight boxes of a lowest node look for the lowest nodes near all of them
/// in one descent. The order of equal codes is that of the boxes: the same boxes give the same tree.
#pragma once

#include "base/inline.hpp"
#include "collision/box.hpp"

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include <experimental/simd>

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
  /// Builds the tree; costs a sort. Fewer than 2^31 boxes.
  explicit Bvh(std::span<const Box> boxes);

  /// Takes other boxes, as many, of what has moved a little: the order stays, and with it the tree's quality falls as
  /// neighbours part. The answers are always right.
  void refit(std::span<const Box> boxes);

  std::size_t size() const { return size_; }

  /// At most so many (at least 8) boxes that together hold all of the tree: those of its finest level with so few.
  std::vector<Box> cover(std::size_t at_most) const;

  /// f(number) of every box that overlaps this one, in no particular order.
  template <class F>
  void for_each_overlap(const Box& box, const F& f) const;
  /// f(i, j) for every two boxes that overlap, i of this tree and j of the other, in no particular order.
  template <class F>
  void for_each_overlap(const Bvh& other, const F& f) const;
  /// f(i, j) for every two boxes of this tree that overlap, i < j, in no particular order.
  template <class F>
  void for_each_overlap(const F& f) const;

 private:
  /// Eight boxes, coordinate by coordinate; absent ones hold nothing.
  struct alignas(32) Node {
    float low[3][width], high[3][width];
  };
  using Lanes = std::experimental::simd<float, std::experimental::simd_abi::deduce_t<float, width>>;

  static Box box_of_lane(const Node& node, int lane);
  /// Bit k: whether box k of the node overlaps this one.
  static std::uint32_t lanes_that_overlap(const Node& node, const Box& box);
  /// The box around all of a node.
  static Box bounds(const Node& node);
  static void set_lane(Node& node, int lane, const Box& box);

  std::int32_t num_lowest() const { return static_cast<std::int32_t>((size_ + width - 1) / width); }
  /// The box around a lowest node, as its parent has it.
  Box box_of_lowest(std::int32_t n) const { return box_of_lane(nodes_[level_begin_[1] + n / width], n % width); }
  /// f(n) for lowest nodes n >= first whose boxes overlap this one.
  template <class F>
  void visit_lowest(const Box& box, std::int32_t first, const F& f) const;

  std::size_t size_ = 0;
  Box bounds_;                             ///< of all boxes
  std::vector<std::int32_t> order_;        ///< the number of each leaf's box, -1 for the absent ones of the last nodes
  std::vector<Node> nodes_;                ///< levels from the lowest to the root, all but the root's in whole eights
  std::vector<std::int32_t> level_begin_;  ///< in nodes_, and its size behind the last; at least two levels
};

/// All pairs (i, j) of box i of one tree and box j of the other that overlap and that accept(i, j) takes, sorted.
template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, const Bvh& other, const Accept& accept);

/// All pairs i < j of boxes of the tree that overlap and that accept(i, j) takes, sorted.
template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, const Accept& accept);

/// What to reserve memory for: on the surfaces of bodies a box meets some ten others around it. Growing costs more
/// time.
inline constexpr std::size_t usual_pairs_per_box = 16;

/// Sorts pairs that differ and whose first numbers are below `num_first`, by counting.
void sort_pairs(std::vector<BoxPair>& pairs, std::size_t num_first);

// ---------------------------------------------------------------------------------------------------------------------

PLIANT_INLINE Box Bvh::box_of_lane(const Node& node, int lane) {
  return {{node.low[0][lane], node.low[1][lane], node.low[2][lane]},
          {node.high[0][lane], node.high[1][lane], node.high[2][lane]}};
}

PLIANT_INLINE std::uint32_t Bvh::lanes_that_overlap(const Node& node, const Box& box) {
  const auto lanes = [](const float* x) { return Lanes(x, std::experimental::vector_aligned); };
  const auto hits = lanes(node.low[0]) <= box.high[0] && lanes(node.high[0]) >= box.low[0] &&
                    lanes(node.low[1]) <= box.high[1] && lanes(node.high[1]) >= box.low[1] &&
                    lanes(node.low[2]) <= box.high[2] && lanes(node.high[2]) >= box.low[2];
  return static_cast<std::uint32_t>(hits.__to_bitset().to_ulong());
}

/// f(k) for each bit k that is set.
template <class F>
PLIANT_INLINE void for_each_bit(std::uint32_t bits, const F& f) {
  for (; bits != 0; bits &= bits - 1) f(std::countr_zero(bits));
}

template <class F>
void Bvh::visit_lowest(const Box& box, std::int32_t first, const F& f) const {
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
    for_each_bit(lanes_that_overlap(nodes_[level_begin_[at.level] + at.node], box), [&](int k) {
      const std::int32_t child = width * at.node + k;
      if (child < first >> (3 * (at.level - 1))) return;  // width^(level - 1) lowest nodes each
      if (at.level == 1) {
        f(child);
      } else {
        stack[top++] = {at.level - 1, child};
      }
    });
  }
}

template <class F>
void Bvh::for_each_overlap(const Box& box, const F& f) const {
  visit_lowest(box, 0, [&](std::int32_t n) {
    for_each_bit(lanes_that_overlap(nodes_[n], box), [&](int k) {
      if (const std::int32_t number = order_[width * n + k]; number >= 0) f(number);
    });
  });
}

template <class F>
void Bvh::for_each_overlap(const Bvh& other, const F& f) const {
  if (!bounds_.overlaps(other.bounds_)) return;
  for (std::int32_t m = 0; m < num_lowest(); ++m) {
    other.visit_lowest(box_of_lowest(m), 0, [&](std::int32_t n) {
      for_each_bit(lanes_that_overlap(nodes_[m], other.box_of_lowest(n)), [&](int k) {
        const std::int32_t i = order_[width * m + k];
        for_each_bit(lanes_that_overlap(other.nodes_[n], box_of_lane(nodes_[m], k)), [&](int l) {
          if (const std::int32_t j = other.order_[width * n + l]; i >= 0 && j >= 0) f(i, j);
        });
      });
    });
  }
}

template <class F>
void Bvh::for_each_overlap(const F& f) const {
  // Each pair once, from the one that comes first in the order.
  for (std::int32_t m = 0; m < num_lowest(); ++m) {
    visit_lowest(box_of_lowest(m), m, [&](std::int32_t n) {
      for_each_bit(lanes_that_overlap(nodes_[m], box_of_lowest(n)), [&](int k) {
        const std::int32_t i = order_[width * m + k];
        const std::uint32_t later = n == m ? ~std::uint32_t{1} << k : ~std::uint32_t{0};
        for_each_bit(lanes_that_overlap(nodes_[n], box_of_lane(nodes_[m], k)) & later, [&](int l) {
          const std::int32_t j = order_[width * n + l];
          if (i >= 0 && j >= 0) f(std::min(i, j), std::max(i, j));
        });
      });
    });
  }
}

template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, const Bvh& other, const Accept& accept) {
  std::vector<BoxPair> pairs;
  pairs.reserve(usual_pairs_per_box * tree.size());
  tree.for_each_overlap(other, [&](std::int32_t i, std::int32_t j) {
    if (accept(i, j)) pairs.push_back({i, j});
  });
  sort_pairs(pairs, tree.size());
  return pairs;
}

template <class Accept>
std::vector<BoxPair> overlapping_pairs(const Bvh& tree, const Accept& accept) {
  std::vector<BoxPair> pairs;
  pairs.reserve(usual_pairs_per_box * tree.size());
  tree.for_each_overlap([&](std::int32_t i, std::int32_t j) {
    if (accept(i, j)) pairs.push_back({i, j});
  });
  sort_pairs(pairs, tree.size());
  return pairs;
}

}  // namespace pliant
