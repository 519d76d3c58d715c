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

constexpr std::size_t in_eights(std::size_t n) {
  return (n + Bvh::width - 1) / Bvh::width;
}

/// By the upper 32 bits, of which 30 are used, in three passes of ten bits; few of them by comparisons.
void sort_by_code(std::vector<std::uint64_t>& codes) {
  constexpr std::size_t few = 500;
  if (codes.size() < few) {
    std::ranges::sort(codes);
    return;
  }
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

/// Sorts pairs with the same first number. A few by counting how many are less than each, which takes no branches.
void sort_by_second(std::span<BoxPair> pairs) {
  using Lanes = std::experimental::simd<std::int32_t, std::experimental::simd_abi::deduce_t<std::int32_t, 8>>;
  constexpr std::size_t few = 32;
  if (pairs.size() > few) {
    std::ranges::sort(pairs, {}, &BoxPair::second);
    return;
  }
  alignas(32) std::array<std::int32_t, few> numbers;
  const std::size_t end = Lanes::size() * ((pairs.size() + Lanes::size() - 1) / Lanes::size());
  for (std::size_t n = 0; n < pairs.size(); ++n) numbers[n] = pairs[n].second;
  for (std::size_t n = pairs.size(); n < end; ++n) numbers[n] = std::numeric_limits<std::int32_t>::max();
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    int num_less = 0;
    for (std::size_t k = 0; k < end; k += Lanes::size()) {
      num_less += popcount(Lanes(&numbers[k], std::experimental::vector_aligned) < numbers[n]);
    }
    pairs[num_less].second = numbers[n];
  }
}

}  // namespace

Bvh::Bvh(std::span<const Box> boxes) : size_(boxes.size()) {
  if (boxes.empty()) return;
  auto codes = numbered_codes(boxes);
  sort_by_code(codes);
  level_begin_ = {0};
  std::size_t num_nodes = 0, level_size = size_;
  bool is_root = false;
  while (!is_root) {
    level_size = in_eights(level_size);
    is_root = level_size == 1 && level_begin_.size() > 1;
    num_nodes += is_root ? 1 : width * in_eights(level_size);
    level_begin_.push_back(static_cast<std::int32_t>(num_nodes));
  }
  Node empty;
  for (int lane = 0; lane < width; ++lane) set_lane(empty, lane, {});
  nodes_.assign(num_nodes, empty);
  order_.assign(static_cast<std::size_t>(width * level_begin_[1]), -1);
  std::ranges::transform(codes, order_.begin(), [](std::uint64_t code) { return static_cast<std::int32_t>(code); });
  refit(boxes);
}

void Bvh::set_lane(Node& node, int lane, const Box& box) {
  for (int k = 0; k < 3; ++k) {
    node.low[k][lane] = box.low[k];
    node.high[k][lane] = box.high[k];
  }
}

Box Bvh::bounds(const Node& node) {
  const auto lanes = [](const float* x) { return Lanes(x, std::experimental::vector_aligned); };
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::experimental::hmin(lanes(node.low[k]));
    box.high[k] = std::experimental::hmax(lanes(node.high[k]));
  }
  return box;
}

void Bvh::refit(std::span<const Box> boxes) {
  assert(boxes.size() == size());
  if (size_ == 0) return;
  // Boxes with a NaN are left out of the nodes above.
  const Box nothing;
  constexpr std::int32_t ahead = 8;  // nodes whose boxes are fetched early, as they lie scattered
  const std::int32_t last = std::max(0, num_lowest() - ahead);
  for (std::int32_t n = 0; n < level_begin_[1]; ++n) {
    for (int lane = 0; lane < width && n < last; ++lane) {
      __builtin_prefetch(boxes.data() + std::max(0, order_[width * (n + ahead) + lane]));
    }
    Box around;
    for (int lane = 0; lane < width; ++lane) {
      const std::int32_t number = order_[width * n + lane];
      const Box& box = number >= 0 ? boxes[number] : nothing;
      set_lane(nodes_[n], lane, box);
      around.include(box);
    }
    set_lane(nodes_[level_begin_[1] + n / width], n % width, around);
  }
  for (std::size_t level = 1; level + 2 < level_begin_.size(); ++level) {
    const std::int32_t begin = level_begin_[level], end = level_begin_[level + 1];
    for (std::int32_t n = begin; n < end; ++n) {
      set_lane(nodes_[end + (n - begin) / width], (n - begin) % width, bounds(nodes_[n]));
    }
  }
  bounds_ = bounds(nodes_.back());
}

std::vector<Box> Bvh::cover(std::size_t at_most) const {
  std::vector<Box> boxes;
  if (size_ == 0) return boxes;
  std::size_t level = 0, number = size_;
  for (; number > at_most && level + 2 < level_begin_.size(); ++level) number = in_eights(number);
  boxes.resize(number);
  for (std::size_t n = 0; n < number; ++n) {
    boxes[n] = box_of_lane(nodes_[level_begin_[level] + n / width], static_cast<int>(n % width));
  }
  return boxes;
}

void sort_pairs(std::vector<BoxPair>& pairs, std::size_t num_first) {
  std::vector<std::size_t> begin(num_first + 1, 0);
  for (const BoxPair& pair : pairs) ++begin[pair.first + 1];
  for (std::size_t i = 0; i < num_first; ++i) begin[i + 1] += begin[i];
  std::vector<BoxPair> sorted(pairs.size());
  for (const BoxPair& pair : pairs) sorted[begin[pair.first]++] = pair;
  std::size_t first = 0;
  for (std::size_t i = 0; i < num_first; ++i) {  // begin[i] is now where those of i end
    sort_by_second(std::span(sorted).subspan(first, begin[i] - first));
    first = begin[i];
  }
  pairs.swap(sorted);
}

}  // namespace pliant
