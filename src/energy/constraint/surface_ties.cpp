#include "energy/constraint/surface_ties.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace pliant {
namespace {

/// Largest distance of partners, relative to the extent of the surfaces.
constexpr double matching = 1e-6;

struct PlacedNode {
  PetscInt node;  // global
  Vector3<double> X;
};

/// Gathers the nodes of all ranks on every rank, by place: in an order that does not depend on the ranks. Collective.
std::vector<PlacedNode> placed(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  std::vector<PlacedNode> mine;
  for (const PetscInt n : nodes) mine.push_back({layout.global_node(n), layout.position(n)});
  auto all = gathered(layout.comm, mine);
  std::ranges::stable_sort(all, {}, &PlacedNode::X);
  return all;
}

struct NodeBox {
  Vector3<double> lower{HUGE_VAL, HUGE_VAL, HUGE_VAL}, upper{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  explicit NodeBox(std::span<const PlacedNode> nodes) {
    for (const auto& node : nodes) {
      for (std::size_t i = 0; i < 3; ++i) {
        lower[i] = std::min(lower[i], node.X[i]);
        upper[i] = std::max(upper[i], node.X[i]);
      }
    }
  }
  double extent() const { return std::max({upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]}); }
};

/// Finds nodes by position, to a tolerance.
class Finder {
 public:
  Finder(std::span<const PlacedNode> nodes, double tolerance) : nodes_(nodes), tolerance_(tolerance) {
    for (std::size_t k = 0; k < nodes.size(); ++k) cells_[cell(nodes[k].X)].push_back(k);
  }

  /// The index in the list, or the length of the list if there is none.
  std::size_t operator()(const Vector3<double>& X) const {
    const auto c = cell(X);
    for (long i = -1; i <= 1; ++i) {
      for (long j = -1; j <= 1; ++j) {
        for (long k = -1; k <= 1; ++k) {
          const auto found = cells_.find({c[0] + i, c[1] + j, c[2] + k});
          if (found == cells_.end()) continue;
          for (const std::size_t n : found->second) {
            const auto d = nodes_[n].X - X;
            if (dot(d, d) <= tolerance_ * tolerance_) return n;
          }
        }
      }
    }
    return nodes_.size();
  }

 private:
  using Cell = std::array<long, 3>;
  Cell cell(const Vector3<double>& X) const {
    return {std::lround(X[0] / tolerance_), std::lround(X[1] / tolerance_), std::lround(X[2] / tolerance_)};
  }
  std::span<const PlacedNode> nodes_;
  double tolerance_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<LinearConstraint> ties_along(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                         const Vector3<double>& direction, std::size_t source) {
  std::vector<LinearConstraint> result;
  for (const PetscInt n : nodes) {
    LinearConstraint& c = result.emplace_back();
    c.source = source;
    for (int i = 0; i < 3; ++i) {
      if (direction[i] != 0.0) c.entries.push_back({3 * layout.global_node(n) + i, direction[i]});
    }
    c.given.push_back({1.0, source, 0, layout.position(n)});
  }
  return result;
}

PeriodicPairs match_periodic(const NodeLayout& layout, std::span<const PetscInt> nodes_a,
                             std::span<const PetscInt> nodes_b) {
  const auto a = placed(layout, nodes_a), b = placed(layout, nodes_b);
  PeriodicPairs result;
  if (a.empty() || b.empty()) return result;
  const NodeBox around_a(a), around_b(b);
  result.translation = around_b.lower - around_a.lower;
  const Finder find(a, matching * std::max(around_a.extent(), around_b.extent()));
  std::vector<char> is_matched(a.size(), 0);
  for (const auto& [node, X] : b) {
    const std::size_t partner = find(X - result.translation);
    if (partner == a.size() || is_matched[partner]) {
      if (result.num_unmatched_b++ == 0) result.unmatched = X;
    } else {
      is_matched[partner] = 1;
      result.pairs.push_back({a[partner].node, node, X});
    }
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (is_matched[k]) continue;
    if (result.num_unmatched_a++ == 0 && result.num_unmatched_b == 0) result.unmatched = a[k].X;
  }
  return result;
}

std::vector<LinearConstraint> periodic(const PeriodicPairs& pairs, const GivenDisplacement& given, std::size_t source) {
  std::vector<LinearConstraint> result;
  for (const auto& [a, b, X] : pairs.pairs) {
    if (a == b) continue;
    for (int i = 0; i < 3; ++i) {
      LinearConstraint c{{{3 * b + i, 1.0}, {3 * a + i, -1.0}}, {}, source};
      if (given.gives(i)) {
        c.given.push_back({1.0, source, i, X});
      } else {
        const auto& first = pairs.pairs.front();
        if (b == first.b) continue;
        c.entries.push_back({3 * first.b + i, -1.0});
        c.entries.push_back({3 * first.a + i, 1.0});
      }
      result.push_back(std::move(c));
    }
  }
  return result;
}

std::vector<LinearConstraint> translated_together(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                                  const GivenDisplacement& given, std::size_t source) {
  const auto all = placed(layout, nodes);
  std::vector<LinearConstraint> result;
  if (all.empty()) return result;
  const PlacedNode& first = all.front();
  for (const PetscInt n : nodes) {
    const PetscInt node = layout.global_node(n);
    if (node == first.node) continue;
    for (int i = 0; i < 3; ++i) {
      if (given.gives(i)) continue;
      result.push_back({{{3 * node + i, 1.0}, {3 * first.node + i, -1.0}},
                        {{1.0, source, i, layout.position(n)}, {-1.0, source, i, first.X}},
                        source});
    }
  }
  return result;
}

LinearConstraint tie_of_means(const NodeLayout& layout, std::span<const MeanTerm> terms, std::size_t source) {
  LinearConstraint result{{}, {{1.0, source, 0, {}}}, source};
  for (const MeanTerm& term : terms) {
    const auto all = placed(layout, term.nodes);
    const double share = term.coefficient / static_cast<double>(all.size());
    for (const auto& node : all) result.entries.push_back({3 * node.node + term.component, share});
  }
  return result;
}

}  // namespace pliant
