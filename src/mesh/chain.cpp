#include "mesh/chain.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace pliant {
namespace {

using Place = std::array<double, 3>;

struct Joined {
  std::vector<std::size_t> edges;
  std::size_t num_begun = 0;  // of these, with the point as their first
};

/// The points that the edges join, by their coordinates.
std::map<Place, Joined> points_of(std::span<const MeshCurve::Edge> edges) {
  std::map<Place, Joined> points;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    points[edges[e].from].edges.push_back(e);
    ++points[edges[e].from].num_begun;
    points[edges[e].to].edges.push_back(e);
  }
  return points;
}

std::string in_words(const Place& X) {
  return fmt::format("({:g}, {:g}, {:g})", X[0], X[1], X[2]);
}

}  // namespace

Chain chain_of(std::span<const MeshCurve::Edge> edges, const std::string& what) {
  Chain chain;
  const std::map<Place, Joined> points = points_of(edges);
  std::vector<Place> ends;
  for (const auto& [X, joined] : points) {
    if (joined.edges.size() == 1) ends.push_back(X);
    if (joined.edges.size() < 3) continue;
    chain.fault = fmt::format("branches at {}; {} is one line: make a group of each branch", in_words(X), what);
    return chain;
  }
  if (ends.empty()) {
    chain.fault = fmt::format("is closed, and {} has two ends: leave a curve out of the group", what);
    return chain;
  }
  if (ends.size() > 2) {
    chain.fault = fmt::format("consists of {} pieces that do not meet; {} is one line: make a group of each",
                              ends.size() / 2, what);
    return chain;
  }
  // From the end that an edge begins at; if both or none are, from the first in the order of coordinates.
  const bool turned = points.at(ends[0]).num_begun == 0 && points.at(ends[1]).num_begun == 1;
  Place at = ends[turned ? 1 : 0];
  chain.points.push_back(at);
  std::vector<char> is_used(edges.size(), 0);
  while (chain.points.size() <= edges.size()) {
    const auto& joined = points.at(at).edges;
    const auto next = std::ranges::find_if(joined, [&](std::size_t e) { return is_used[e] == 0; });
    if (next == joined.end()) break;
    is_used[*next] = 1;
    chain.is_directed = chain.is_directed && edges[*next].from == at;
    at = edges[*next].from == at ? edges[*next].to : edges[*next].from;
    chain.points.push_back(at);
  }
  if (chain.points.size() <= edges.size()) {
    chain.fault =
        fmt::format("consists of a line and closed loops; {} is one line: leave the loops out of the group", what);
  }
  return chain;
}

std::vector<Place> halved(std::vector<Place> points, int times) {
  for (int time = 0; time < times; ++time) {
    std::vector<Place> finer{points.front()};
    for (std::size_t k = 1; k < points.size(); ++k) {
      Place middle{};
      for (std::size_t i = 0; i < 3; ++i) middle[i] = 0.5 * (points[k - 1][i] + points[k][i]);
      finer.insert(finer.end(), {middle, points[k]});
    }
    points = std::move(finer);
  }
  return points;
}

}  // namespace pliant
