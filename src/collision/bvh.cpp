#include "collision/bvh.hpp"

#include <cassert>
#include <utility>

namespace pliant {
namespace {

constexpr int code_bits = 10;  // a coordinate

/// Two zeros between every two of the lowest ten bits.
std::uint32_t spread(std::uint32_t x) {
  x = (x | (x << 16)) & 0x030000FFU;
  x = (x | (x << 8)) & 0x0300F00FU;
  x = (x | (x << 4)) & 0x030C30C3U;
  x = (x | (x << 2)) & 0x09249249U;
  return x;
}

/// Codes above, numbers below: sorting them by code keeps the order of equal ones.
std::vector<std::uint64_t> numbered_codes(std::span<const Box> boxes) {
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  for (const Box& box : boxes) {  // of twice the centres
    for (int k = 0; k < 3; ++k) {
      const float centre = box.low[k] + box.high[k];
      low[k] = std::min(low[k], centre);
      high[k] = std::max(high[k], centre);
    }
  }
  // One scale for all directions: cells of the curve are cubes.
  const float extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  constexpr float most = (1 << code_bits) - 1;
  const float scale = extent > 0.0F && std::isfinite(extent) ? most / extent : 0.0F;
  std::vector<std::uint64_t> codes(boxes.size());
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    std::uint32_t code = 0;
    for (int k = 0; k < 3; ++k) {
      const float place = (boxes[n].low[k] + boxes[n].high[k] - low[k]) * scale;
      code |= spread(static_cast<std::uint32_t>(place > 0.0F ? std::min(place, most) : 0.0F)) << k;  // NaN: 0
    }
    codes[n] = std::uint64_t{code} << 32 | n;
  }
  return codes;
}

/// By the upper 32 bits, of which 30 are used: three passes of ten bits.
void radix_sort(std::vector<std::uint64_t>& codes) {
  constexpr int digit_bits = 10, num_digits = 1 << digit_bits;
  std::vector<std::uint64_t> other(codes.size());
  std::array<std::array<std::uint32_t, num_digits>, 3> begin{};
  const auto digit = [](std::uint64_t code, int pass) {
    return static_cast<std::size_t>(code >> (32 + digit_bits * pass)) & (num_digits - 1);
  };
  for (const std::uint64_t code : codes) {
    for (int pass = 0; pass < 3; ++pass) ++begin[pass][digit(code, pass)];
  }
  for (int pass = 0; pass < 3; ++pass) {
    std::uint32_t total = 0;
    for (auto& count : begin[pass]) total += std::exchange(count, total);
    for (const std::uint64_t code : codes) other[begin[pass][digit(code, pass)]++] = code;
    codes.swap(other);
  }
}

}  // namespace

Bvh::Bvh(std::span<const Box> boxes) {
  if (boxes.empty()) return;
  auto codes = numbered_codes(boxes);
  radix_sort(codes);
  order_.resize(boxes.size());
  std::ranges::transform(codes, order_.begin(), [](std::uint64_t code) { return static_cast<std::int32_t>(code); });
  level_begin_ = {0};
  std::size_t num_nodes = 0, level_size = boxes.size();
  do {
    level_size = (level_size + width - 1) / width;
    num_nodes += level_size;
    level_begin_.push_back(static_cast<std::int32_t>(num_nodes));
  } while (level_size > 1);
  Node empty;
  std::ranges::fill(std::span(&empty.low[0][0], 3 * width), std::numeric_limits<float>::infinity());
  std::ranges::fill(std::span(&empty.high[0][0], 3 * width), -std::numeric_limits<float>::infinity());
  nodes_.assign(num_nodes, empty);
  refit(boxes);
}

void Bvh::refit(std::span<const Box> boxes) {
  assert(boxes.size() == size());
  set_leaves(boxes);
  set_parents();
}

void Bvh::set_leaves(std::span<const Box> boxes) {
  for (std::size_t leaf = 0; leaf < order_.size(); ++leaf) {
    Node& node = nodes_[leaf / width];
    const Box& box = boxes[order_[leaf]];
    const std::size_t lane = leaf % width;
    for (int k = 0; k < 3; ++k) {
      node.low[k][lane] = box.low[k];
      node.high[k][lane] = box.high[k];
    }
  }
}

void Bvh::set_parents() {
  for (std::size_t level = 1; level + 1 < level_begin_.size(); ++level) {
    const std::int32_t first_child = level_begin_[level - 1], num_children = level_begin_[level] - first_child;
    for (std::int32_t child = 0; child < num_children; ++child) {
      const Node& node = nodes_[first_child + child];
      Node& parent = nodes_[level_begin_[level] + child / width];
      for (int k = 0; k < 3; ++k) {
        float low = node.low[k][0], high = node.high[k][0];
        for (int lane = 1; lane < width; ++lane) {
          low = std::min(low, node.low[k][lane]);
          high = std::max(high, node.high[k][lane]);
        }
        parent.low[k][child % width] = low;
        parent.high[k][child % width] = high;
      }
    }
  }
}

void sort_pairs(std::vector<BoxPair>& pairs, std::size_t num_first) {
  std::vector<std::size_t> begin(num_first + 1, 0);
  for (const BoxPair& pair : pairs) ++begin[pair.first + 1];
  for (std::size_t i = 0; i < num_first; ++i) begin[i + 1] += begin[i];
  std::vector<BoxPair> sorted(pairs.size());
  for (const BoxPair& pair : pairs) sorted[begin[pair.first]++] = pair;
  std::size_t first = 0;
  for (std::size_t i = 0; i < num_first; ++i) {  // begin[i] is now where those of i end
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first),
              sorted.begin() + static_cast<std::ptrdiff_t>(begin[i]));
    first = begin[i];
  }
  pairs.swap(sorted);
}

}  // namespace pliant
