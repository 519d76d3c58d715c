/// Union-find: which items are connected.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace pliant {

/// Disjoint sets of 0 .. n - 1, with path halving.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { parent_[root(i)] = root(j); }
  std::size_t count() const {
    std::size_t n = 0;
    for (std::size_t i = 0; i < parent_.size(); ++i) n += parent_[i] == i ? 1 : 0;
    return n;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace pliant
