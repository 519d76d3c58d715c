#include "energy/pairs/patch_search.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant {
namespace {

/// The skin in units of the slack: the least, and the most, which bounds how many pairs are looked at in vain.
constexpr double least_skin = 1.0, largest_skin = 8.0;

/// How far a node may move in one search, in units of the size of patches with the reach around them. A
/// triangle among equal ones then meets at most about 4 (1 + longest_path)^2 triangles of one surface.
constexpr double longest_path = 4.0;

/// Pairs of a path serve other paths down to this part of its length, so that what a long one met is soon forgotten.
constexpr double shortest_reuse = 0.25;

}  // namespace

PatchSearch::PatchSearch(const NodeLayout& layout, const PairCoupling& coupling)
    : layout_(layout),
      coupling_(coupling),
      kinds_(layout.comm, coupling),
      order_(coupling.patches().size()),
      skin_(least_skin * coupling.slack()),
      trees_(kinds_.size()) {
  const Patches& patches = coupling.patches();
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::sort(order_, {}, [&](std::int32_t patch) { return patches.keys[patch]; });
  for (const int tag : patches.tags) {
    const std::int32_t kind = kinds_.kind_of(tag);
    trees_[kind].patches.push_back(static_cast<std::int32_t>(kind_of_patch_.size()));
    kind_of_patch_.push_back(kind);
  }
  number_nodes();
  limit_paths();
}

void PatchSearch::number_nodes() {
  const std::vector<PetscInt>& all = coupling_.patches().nodes;
  nodes_ = all;
  std::ranges::sort(nodes_);
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  std::vector<std::int32_t> number(static_cast<std::size_t>(layout_.num_local_nodes));
  for (std::size_t n = 0; n < nodes_.size(); ++n) number[nodes_[n]] = static_cast<std::int32_t>(n);
  corners_.reserve(all.size());
  for (const PetscInt node : all) corners_.push_back(number[node]);
}

namespace {

/// What holds the point if these hold its nodes.
template <class BoxOfNode>
Box box_of_point(const PatchPoint& point, const BoxOfNode& box_of_node) {
  if (point.weights[1] == 0.0 && point.weights[2] == 0.0) return box_of_node(point.nodes[0]);
  Vector3<double> low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    const Box box = box_of_node(point.nodes[a]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [least, most] = std::minmax({point.weights[a] * box.low[k], point.weights[a] * box.high[k]});
      low[k] += least;
      high[k] += most;
    }
  }
  return box_of(0.0, low, high);
}

}  // namespace

template <class BoxOfNode>
Box PatchSearch::box_of_patch(std::size_t patch, const BoxOfNode& box_of_node) const {
  const Patches& patches = coupling_.patches();
  const auto num_nodes = static_cast<std::size_t>(patches.nodes_per_patch);
  const auto of_patch = [&](std::size_t a) { return box_of_node(patch * num_nodes + a); };
  Box box;
  if (patches.points_per_patch == 0) {
    for (std::size_t a = 0; a < num_nodes; ++a) box.include(of_patch(a));
  }
  const auto num_points = static_cast<std::size_t>(patches.points_per_patch);
  for (const PatchPoint& point : std::span(patches.points).subspan(patch * num_points, num_points)) {
    box.include(box_of_point(point, of_patch));
  }
  return box;
}

// A patch of size h, reach included, that moves by l meets about (l / h)^2 others: the mean of this bounds l.
void PatchSearch::limit_paths() {
  const Patches& patches = coupling_.patches();
  std::vector<double> sums(2, 0.0);
  for (std::size_t patch = 0; patch < patches.size(); ++patch) {
    if (!patches.is_owned[patch]) continue;
    const Box box =
        box_of_patch(patch, [&](std::size_t place) { return box_of(0.0, layout_.position(patches.nodes[place])); });
    double size = 0.0;
    for (std::size_t k = 0; k < 3; ++k) size = std::max(size, double{box.high[k]} - double{box.low[k]});
    sums[0] += 1.0;
    sums[1] += std::pow(size + coupling_.reach(), -2);
  }
  sum_in_place(layout_.comm, sums);
  longest_path_ = longest_path * std::sqrt(sums[0] / sums[1]);
}

Vector3<double> PatchSearch::position(PetscInt node, std::span<const double> q) const {
  const Vector3<double> X = layout_.position(node);
  const auto i = 3 * static_cast<std::size_t>(node);
  return {X[0] + q[i], X[1] + q[i + 1], X[2] + q[i + 2]};
}

double PatchSearch::length(std::span<const double> d) const {
  double longest = 0.0;
  for (const PetscInt node : nodes_) {
    const auto i = 3 * static_cast<std::size_t>(node);
    for (std::size_t k = 0; k < 3 && !d.empty(); ++k) longest = std::max(longest, std::abs(d[i + k]));
  }
  return longest;
}

double PatchSearch::searchable_part(std::span<const double> d) const {
  if (coupling_.fixed_pairs() != nullptr) return 1.0;
  const double longest = length(d);
  return longest > longest_path_ ? longest_path_ / longest : 1.0;
}

bool PatchSearch::covers(const Path& path) const {
  if (coupling_.fixed_pairs() != nullptr) return has_searched_;
  if (node_boxes_.size() != nodes_.size()) return false;
  if (searched_length_ > skin_ && path.end * length(path.d) < shortest_reuse * searched_length_) return false;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Vector3<double> x = position(nodes_[n], path.q);
    if (!node_boxes_[n].contains(x)) return false;
    if (path.d.empty()) continue;
    const auto i = 3 * static_cast<std::size_t>(nodes_[n]);
    const Vector3<double> d{path.d[i], path.d[i + 1], path.d[i + 2]};
    if (!node_boxes_[n].contains(x + path.end * d)) return false;
  }
  return true;
}

void PatchSearch::widen_skin(std::span<const double> q) {
  double travelled = 0.0;  // beyond the boxes of the last search
  for (std::size_t n = 0; n < node_boxes_.size(); ++n) {
    const Box& box = node_boxes_[n];
    const Vector3<double> x = position(nodes_[n], q);
    for (std::size_t k = 0; k < 3; ++k) travelled = std::max({travelled, box.low[k] - x[k], x[k] - box.high[k]});
  }
  travelled = maximum(layout_.comm, travelled);
  skin_ = std::clamp(skin_ + travelled, least_skin * coupling_.slack(), largest_skin * coupling_.slack());
}

void PatchSearch::set_boxes(const Path& path) {
  searched_length_ = path.end * length(path.d);
  node_boxes_.resize(nodes_.size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Vector3<double> x = position(nodes_[n], path.q);
    const auto i = 3 * static_cast<std::size_t>(nodes_[n]);
    const Vector3<double> d = path.d.empty() || path.end == 0.0
                                  ? Vector3<double>{}
                                  : Vector3<double>{path.d[i], path.d[i + 1], path.d[i + 2]};
    node_boxes_[n] = box_of(0.5 * skin_, x, x + path.end * d);
  }
  patch_boxes_.resize(coupling_.patches().size());
  for (std::size_t patch = 0; patch < patch_boxes_.size(); ++patch) {
    const Box box = box_of_patch(patch, [&](std::size_t place) { return node_boxes_[corners_[place]]; });
    patch_boxes_[patch] = box.grown(0.5 * coupling_.reach());
  }
  std::vector<Box> boxes;
  for (KindTree& of : trees_) {
    boxes.clear();
    for (const std::int32_t patch : of.patches) boxes.push_back(patch_boxes_[patch]);
    of.tree = Bvh(boxes);
  }
}

std::vector<BoxPair> PatchSearch::find_pairs(std::span<const ForeignPatch> foreign,
                                             std::span<const std::int32_t> places) const {
  const std::span<const std::int32_t> foreign_places = places.subspan(kind_of_patch_.size());
  std::vector<std::vector<std::int32_t>> foreign_of_kind(trees_.size());
  for (std::size_t n = 0; n < foreign.size(); ++n) foreign_of_kind[foreign[n].kind].push_back(static_cast<int>(n));

  std::vector<BoxPair> pairs;
  pairs.reserve(usual_pairs_per_box * kind_of_patch_.size());
  const auto add = [&](std::int32_t place, std::int32_t other) {
    pairs.push_back({std::min(place, other), std::max(place, other)});
  };
  std::vector<Box> boxes;
  const auto num_kinds = static_cast<std::int32_t>(trees_.size());
  for (std::int32_t b = 0; b < num_kinds; ++b) {
    boxes.clear();
    for (const std::int32_t n : foreign_of_kind[b]) boxes.push_back(foreign[n].box);
    const Bvh foreign_tree(boxes);
    for (std::int32_t a = 0; a < num_kinds; ++a) {
      if (!kinds_.may_couple(a, b)) continue;
      const KindTree &mine = trees_[a], &others = trees_[b];
      mine.tree.for_each_overlap(foreign_tree, [&](std::int32_t i, std::int32_t j) {
        add(places[mine.patches[i]], foreign_places[foreign_of_kind[b][j]]);
      });
      const auto add_own = [&](std::int32_t i, std::int32_t j) {
        add(places[mine.patches[i]], places[others.patches[j]]);
      };
      if (a == b) mine.tree.for_each_overlap(add_own);
      if (a < b) mine.tree.for_each_overlap(others.tree, add_own);
    }
  }
  sort_pairs(pairs, places.size());
  return pairs;
}

FoundPatches PatchSearch::search(const Path& path) {
  has_searched_ = true;
  if (const FixedPairs* fixed = coupling_.fixed_pairs()) {
    FoundPatches found{coupling_.patches().keys, coupling_.patches().tags, fixed->global_nodes, fixed->pairs};
    found.keys.insert(found.keys.end(), fixed->keys.begin(), fixed->keys.end());
    found.tags.insert(found.tags.end(), fixed->tags.begin(), fixed->tags.end());
    return found;
  }
  widen_skin(path.q);
  set_boxes(path);
  const Patches& patches = coupling_.patches();
  ForeignPatches foreign = foreign_patches_near(layout_, kinds_, {patches, kind_of_patch_, patch_boxes_, trees_});
  const auto key_of = [&](std::int32_t patch) { return patches.keys[patch]; };
  std::erase_if(foreign.patches, [&](const ForeignPatch& patch) {  // this rank has them itself
    const auto same = std::ranges::lower_bound(order_, patch.key, {}, key_of);
    return same != order_.end() && key_of(*same) == patch.key;
  });

  // Places in the order of all keys, and what is there: numbers below num_local of this rank's patches, then the
  // others.
  const auto num_local = static_cast<std::int32_t>(patches.size()),
             num_all = num_local + static_cast<std::int32_t>(foreign.patches.size());
  std::vector<std::int32_t> at_place = order_, places(static_cast<std::size_t>(num_all));
  for (std::int32_t n = num_local; n < num_all; ++n) at_place.push_back(n);
  std::ranges::inplace_merge(at_place, at_place.begin() + num_local, {}, [&](std::int32_t n) {
    return n < num_local ? key_of(n) : foreign.patches[n - num_local].key;
  });
  for (std::int32_t n = 0; n < num_all; ++n) places[at_place[n]] = n;
  const std::vector<BoxPair> pairs = find_pairs(foreign.patches, places);

  // The others are kept only if they are near, and get the numbers after this rank's.
  FoundPatches found{patches.keys, patches.tags, {}, {}};
  std::vector<char> is_near(places.size(), 0);
  for (const BoxPair& pair : pairs) is_near[pair.first] = is_near[pair.second] = 1;
  const auto nodes_per_patch = static_cast<std::size_t>(patches.nodes_per_patch);
  for (std::int32_t n = num_local; n < num_all; ++n) {
    if (!is_near[places[n]]) continue;
    const ForeignPatch& patch = foreign.patches[n - num_local];
    at_place[places[n]] = static_cast<std::int32_t>(found.keys.size());
    found.keys.push_back(patch.key);
    found.tags.push_back(kinds_.tag_of(patch.kind));
    const auto nodes = foreign.global_nodes.begin() + static_cast<std::ptrdiff_t>(patch.place * nodes_per_patch);
    found.global_nodes.insert(found.global_nodes.end(), nodes, nodes + patches.nodes_per_patch);
  }
  for (const BoxPair& pair : pairs) {
    found.pairs.push_back(
        {static_cast<std::size_t>(at_place[pair.first]), static_cast<std::size_t>(at_place[pair.second])});
  }
  return found;
}

}  // namespace pliant
