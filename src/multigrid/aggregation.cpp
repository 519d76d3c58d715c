#include "multigrid/aggregation.hpp"

#include <cmath>

namespace pliant {
namespace {

/// Neighbours count as bound to each other if their block is at least this fraction of the blocks of both.
constexpr float least_strength = 0.02F;

/// The graph of bound nodes.
struct Graph {
  std::vector<int> offsets{0}, neighbours;
  std::vector<float> strengths;

  template <class Body>
  void for_each(int node, Body body) const {
    const auto i = static_cast<std::size_t>(node);
    for (auto k = static_cast<std::size_t>(offsets[i]); k < static_cast<std::size_t>(offsets[i + 1]); ++k) {
      body(neighbours[k], strengths[k]);
    }
  }
};

float size_of(const BlockCsr& A, std::size_t k) {
  float squares = 0.0F;
  const float* const block = A.block(k);
  for (std::size_t e = 0; e < A.block_size(); ++e) squares += block[e] * block[e];
  return std::sqrt(squares);
}

Graph make_graph(const BlockCsr& A) {
  const int n = A.num_rows();
  std::vector<float> diagonal(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    for (std::size_t k = A.begin(i); k < A.end(i); ++k) {
      if (A.columns[k] == i) diagonal[static_cast<std::size_t>(i)] = size_of(A, k);
    }
  }
  Graph graph;
  for (int i = 0; i < n; ++i) {
    for (std::size_t k = A.begin(i); k < A.end(i); ++k) {
      const int j = A.columns[k];
      if (j == i || j >= n) continue;
      const float strength =
          size_of(A, k) / std::sqrt(diagonal[static_cast<std::size_t>(i)] * diagonal[static_cast<std::size_t>(j)]);
      if (!(strength > least_strength)) continue;
      graph.neighbours.push_back(j);
      graph.strengths.push_back(strength);
    }
    graph.offsets.push_back(static_cast<int>(graph.neighbours.size()));
  }
  return graph;
}

}  // namespace

Aggregates aggregate(const BlockCsr& A) {
  const Graph graph = make_graph(A);
  const int n = A.num_rows();
  constexpr int none = -1;
  std::vector<int> of_node(static_cast<std::size_t>(n), none);
  const auto at = [&](int node) -> int& { return of_node[static_cast<std::size_t>(node)]; };
  int number = 0;
  for (int i = 0; i < n; ++i) {
    bool is_free = at(i) == none, has_neighbours = false;
    graph.for_each(i, [&](int j, float) {
      is_free = is_free && at(j) == none;
      has_neighbours = true;
    });
    if (!is_free || !has_neighbours) continue;
    at(i) = number;
    graph.for_each(i, [&](int j, float) { at(j) = number; });
    ++number;
  }
  // The rest joins what the first pass has made, so that aggregates stay compact.
  const std::vector<int> first_pass = of_node;
  for (int i = 0; i < n; ++i) {
    float strongest = 0.0F;
    if (at(i) != none) continue;
    graph.for_each(i, [&](int j, float strength) {
      if (first_pass[static_cast<std::size_t>(j)] == none || strength <= strongest) return;
      strongest = strength;
      at(i) = first_pass[static_cast<std::size_t>(j)];
    });
  }
  return {std::move(of_node), number};
}

}  // namespace pliant
