#include "energy/pairs/patch_search.hpp"

#include "petsc/collective.hpp"
#include "petsc/exchange.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

namespace pliant {
namespace {

/// The skin in units of the reach: the least, and the most, which bounds how many pairs are looked at in vain.
constexpr double least_skin = 1.0, largest_skin = 8.0;

/// Calls `visit(i, j)` for all pairs of overlapping boxes of which the first is one of the first `num_first`.
template <class Visit>
void for_each_overlap(std::span<const Box> boxes, std::size_t num_first, const Visit& visit) {
  // Swept along the axis on which the boxes lie farthest apart.
  Box all = Box::empty();
  for (const Box& box : boxes) all.include(box);
  std::size_t axis = 0;
  for (const std::size_t i : {std::size_t{1}, std::size_t{2}}) {
    if (all.high[i] - all.low[i] > all.high[axis] - all.low[axis]) axis = i;
  }
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(boxes[i].low[axis], i); });
  for (auto first = order.begin(); first != order.end(); ++first) {
    for (auto second = first + 1; second != order.end() && boxes[*second].low[axis] <= boxes[*first].high[axis];
         ++second) {
      const auto [i, j] = std::minmax(*first, *second);
      if (i < num_first && boxes[i].overlaps(boxes[j])) visit(i, j);
    }
  }
}

}  // namespace

Box Box::empty() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
}

void Box::include(const Vector3<double>& x) {
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] = std::min(low[i], x[i]);
    high[i] = std::max(high[i], x[i]);
  }
}

void Box::include(const Box& other) {
  include(other.low);
  include(other.high);
}

void Box::grow(double by) {
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] -= by;
    high[i] += by;
  }
}

bool Box::contains(const Box& other) const {
  for (std::size_t i = 0; i < 3; ++i) {
    // A box with a NaN contains and is contained in nothing.
    if (!(low[i] <= other.low[i] && other.high[i] <= high[i])) return false;
  }
  return true;
}

bool Box::overlaps(const Box& other) const {
  for (std::size_t i = 0; i < 3; ++i) {
    if (low[i] > other.high[i] || other.low[i] > high[i]) return false;
  }
  return true;
}

PatchSearch::PatchSearch(const NodeLayout& layout, const PairCoupling& coupling)
    : layout_(layout), coupling_(coupling), skin_(least_skin * coupling.reach()) {}

Box PatchSearch::box_of(std::size_t patch, std::span<const double> q, std::span<const double> d) const {
  Box box = Box::empty();
  for (const PetscInt node : coupling_.patches().nodes_of(patch)) {
    Vector3<double> x = layout_.position(node);
    const auto first = 3 * static_cast<std::size_t>(node);
    for (std::size_t i = 0; i < 3; ++i) x[i] += q[first + i];
    box.include(x);
    if (d.empty()) continue;
    for (std::size_t i = 0; i < 3; ++i) x[i] += d[first + i];
    box.include(x);
  }
  box.grow(0.5 * coupling_.reach());
  return box;
}

bool PatchSearch::covers(std::span<const double> q, std::span<const double> d) const {
  if (searched_.size() != coupling_.patches().size()) return false;
  for (std::size_t patch = 0; patch < searched_.size(); ++patch) {
    if (!searched_[patch].contains(box_of(patch, q, d))) return false;
  }
  return true;
}

PatchSearch::Received PatchSearch::exchange() const {
  Box mine = Box::empty();
  for (const Box& box : searched_) mine.include(box);
  std::vector<double> sides(mine.low.begin(), mine.low.end());
  sides.insert(sides.end(), mine.high.begin(), mine.high.end());
  const std::vector<double> of_ranks = gathered(layout_.comm, sides);
  const auto num_ranks_here = static_cast<std::size_t>(num_ranks(layout_.comm));
  const auto me = static_cast<std::size_t>(rank(layout_.comm));

  const Patches& patches = coupling_.patches();
  std::vector<std::vector<std::int64_t>> numbers(num_ranks_here);
  std::vector<std::vector<double>> boxes(num_ranks_here);
  for (std::size_t r = 0; r < num_ranks_here; ++r) {
    if (r == me) continue;
    Box theirs;
    std::copy_n(of_ranks.begin() + static_cast<std::ptrdiff_t>(6 * r), 3, theirs.low.begin());
    std::copy_n(of_ranks.begin() + static_cast<std::ptrdiff_t>(6 * r + 3), 3, theirs.high.begin());
    for (std::size_t patch = 0; patch < patches.size(); ++patch) {
      const Box& box = searched_[patch];
      if (!patches.is_owned[patch] || !box.overlaps(theirs)) continue;
      numbers[r].insert(numbers[r].end(), {patches.keys[patch], patches.tags[patch]});
      for (const PetscInt node : patches.nodes_of(patch)) numbers[r].push_back(layout_.global_node(node));
      boxes[r].insert(boxes[r].end(), box.low.begin(), box.low.end());
      boxes[r].insert(boxes[r].end(), box.high.begin(), box.high.end());
    }
  }
  Received received;
  received.numbers = exchanged(layout_.comm, numbers);
  const std::vector<double> values = exchanged(layout_.comm, boxes);
  received.boxes.resize(values.size() / 6);
  for (std::size_t i = 0; i < received.boxes.size(); ++i) {
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(6 * i), 3, received.boxes[i].low.begin());
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(6 * i + 3), 3, received.boxes[i].high.begin());
  }
  return received;
}

FoundPatches PatchSearch::search(std::span<const double> q, std::span<const double> d) {
  const Patches& patches = coupling_.patches();
  std::vector<Box> around(patches.size());
  double travelled = 0.0;  // beyond the boxes of the last search
  for (std::size_t patch = 0; patch < patches.size(); ++patch) {
    around[patch] = box_of(patch, q, {});
    for (std::size_t i = 0; i < 3 && !searched_.empty(); ++i) {
      const double down = searched_[patch].low[i] - around[patch].low[i],
                   up = around[patch].high[i] - searched_[patch].high[i];
      travelled = std::max({travelled, down, up});
    }
  }
  travelled = maximum(layout_.comm, travelled);
  skin_ = std::clamp(skin_ + travelled, least_skin * coupling_.reach(), largest_skin * coupling_.reach());
  for (std::size_t patch = 0; patch < patches.size(); ++patch) {
    if (!d.empty()) around[patch].include(box_of(patch, q, d));
    around[patch].grow(0.5 * skin_);
  }
  searched_ = std::move(around);

  // Patches of other ranks, but for those that this rank has itself.
  const Received received = exchange();
  const std::size_t width = 2 + static_cast<std::size_t>(patches.nodes_per_patch);
  const std::set<std::int64_t> mine(patches.keys.begin(), patches.keys.end());
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < received.boxes.size(); ++i) {
    if (!mine.contains(received.numbers[width * i])) others.push_back(i);
  }
  std::ranges::sort(others, {}, [&](std::size_t i) { return received.numbers[width * i]; });

  std::vector<Box> boxes = searched_;
  std::vector<std::int64_t> keys = patches.keys;
  std::vector<int> tags = patches.tags;
  for (const std::size_t i : others) {
    boxes.push_back(received.boxes[i]);
    keys.push_back(received.numbers[width * i]);
    tags.push_back(static_cast<int>(received.numbers[width * i + 1]));
  }
  std::vector<PatchPair> pairs;
  for_each_overlap(boxes, patches.size(), [&](std::size_t i, std::size_t j) {
    if (coupling_.may_couple(tags[i], tags[j])) pairs.push_back(keys[i] < keys[j] ? PatchPair{i, j} : PatchPair{j, i});
  });
  std::ranges::sort(pairs, {}, [&](const PatchPair& pair) { return std::pair(keys[pair.first], keys[pair.second]); });

  // The others are kept only if they are near, and get the numbers after this rank's.
  std::vector<std::size_t> number(boxes.size(), boxes.size());
  std::iota(number.begin(), number.begin() + static_cast<std::ptrdiff_t>(patches.size()), std::size_t{0});
  std::vector<char> is_near(boxes.size(), 0);
  for (const PatchPair& pair : pairs) is_near[pair.first] = is_near[pair.second] = 1;
  FoundPatches found{patches.keys, patches.tags, {}, {}};
  for (std::size_t i = patches.size(); i < boxes.size(); ++i) {
    if (!is_near[i]) continue;
    number[i] = found.keys.size();
    found.keys.push_back(keys[i]);
    found.tags.push_back(tags[i]);
    const auto nodes = received.numbers.begin() + static_cast<std::ptrdiff_t>(width * others[i - patches.size()] + 2);
    found.global_nodes.insert(found.global_nodes.end(), nodes, nodes + patches.nodes_per_patch);
  }
  for (const PatchPair& pair : pairs) found.pairs.push_back({number[pair.first], number[pair.second]});
  return found;
}

}  // namespace pliant
