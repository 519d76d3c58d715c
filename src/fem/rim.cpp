#include "fem/rim.hpp"

#include "base/vector3.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"
#include "mesh/disjoint_sets.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace pliant {
namespace {

/// Positions in one plane differ by less than this fraction of an edge's length.
constexpr double edge_flatness = 1e-9;
/// A facet lies along a plane if the angle between their normals has more than this cosine.
constexpr double along_plane = 0.7;
/// Places in one plane differ by less than this part of their size and that of their loop: meshes have rounding errors.
constexpr double loop_flatness = 1e-9;
/// Vector areas of loops below this part of the square of their length are rounding errors.
constexpr double no_area = 1e-6;

std::span<const PetscInt> nodes_of(const NodeLayout& layout, const RimEdge& edge) {
  return std::span(edge.nodes).first(layout.order + 1);
}

/// The directions in which the edge has no extent and its nodes are prescribed, so that this remains so.
std::array<bool, 3> flat_directions(const NodeLayout& layout, const RimEdge& edge, const PrescribedSamples& samples) {
  const auto nodes = nodes_of(layout, edge);
  const auto X0 = layout.position(nodes[0]), X1 = layout.position(nodes[1]);
  const auto chord = Vector3<double>(X1) - X0;
  const double tolerance = edge_flatness * std::sqrt(dot(chord, chord));
  std::array<bool, 3> is_flat{true, true, true};
  for (const PetscInt node : nodes) {
    const auto X = layout.position(node);
    for (int k = 0; k < 3; ++k) {
      is_flat[k] = is_flat[k] && samples.flags[3 * node + k] && std::abs(X[k] - X0[k]) <= tolerance;
      for (const auto& u : samples.displacements) {
        is_flat[k] = is_flat[k] && std::abs(u[3 * node + k] - u[3 * nodes[0] + k]) <= tolerance;
      }
    }
  }
  return is_flat;
}

Rim classify_edge(const NodeLayout& layout, RimEdge& edge, const PrescribedSamples& samples) {
  const auto nodes = nodes_of(layout, edge);
  const auto is_flat = flat_directions(layout, edge, samples);
  const auto is_free = [&](int i) {
    return std::ranges::any_of(nodes, [&](PetscInt node) { return !samples.flags[3 * node + i]; });
  };
  const auto moves = [&](int i) {
    return std::ranges::any_of(nodes, [&](PetscInt node) {
      return std::ranges::any_of(samples.displacements, [&](const auto& u) { return u[3 * node + i] != 0; });
    });
  };
  // Whether motions in the direction i and in another one sweep a coupled volume through the edge's extent in the
  // third.
  const auto couples_with = [&](int other, int third) { return (is_free(other) || moves(other)) && !is_flat[third]; };
  Rim rim = Rim::still;
  edge.plane.reset();
  for (int i = 0; i < 3; ++i) {
    if (moves(i)) rim = std::max(rim, Rim::moving);
    if (!is_free(i)) continue;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    if (couples_with(j, k) || couples_with(k, j)) return Rim::free;
    if (!is_flat[j] && !is_flat[k]) rim = std::max(rim, Rim::moving);
    edge.plane = is_flat[j] ? j : k;
  }
  return rim;
}

/// int x cross x' ds along the edge, in its direction.
template <int Order>
Vector3<double> moment(const NodeLayout& layout, const RimEdge& edge) {
  const auto rule = simplex_rule<1>(2 * Order - 1);
  Vector3<double> result{};
  for (int p = 0; p < rule.size(); ++p) {
    const auto N = Line<Order>::values(rule.points[p]);
    const auto dN = Line<Order>::gradients(rule.points[p]);
    Vector3<double> x{}, tangent{};
    for (std::size_t a = 0; a < N.size(); ++a) {
      const auto X = layout.position(edge.nodes[a]);
      x = x + N[a] * X;
      tangent = tangent + dN[a][0] * X;
    }
    result = result + rule.weights[p] * cross(x, tangent);
  }
  return result;
}

/// int X . N dA / 3 over the owned facets.
template <int Order>
double third_of_flux(const NodeLayout& layout, const FacetList& facets) {
  constexpr int n = Triangle<Order>::num_nodes;
  const auto rule = simplex_rule<2>(Order + 2 * (Order - 1));
  double flux = 0.0;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    if (!facets.is_owned[f]) continue;
    for (int p = 0; p < rule.size(); ++p) {
      const auto N = Triangle<Order>::values(rule.points[p]);
      const auto dN = Triangle<Order>::gradients(rule.points[p]);
      Vector3<double> x{}, x_xi{}, x_eta{};
      for (int a = 0; a < n; ++a) {
        const auto X = layout.position(facets.nodes[f * n + a]);
        x = x + N[a] * X;
        x_xi = x_xi + dN[a][0] * X;
        x_eta = x_eta + dN[a][1] * X;
      }
      flux += rule.weights[p] * dot(x, cross(x_xi, x_eta));
    }
  }
  return flux / 3.0;
}

/// The data of an edge that ranks exchange.
struct EdgeRecord {
  PetscInt start = 0, end = 0;   ///< global nodes
  int plane = -1;                ///< RimEdge::plane, or -1
  Vector3<double> X{}, end_X{};  ///< of the start and of the end [m]
  Vector3<double> moment{};      ///< of the edge [m^2]
  double length = 0.0;           ///< [m]
  int is_along_wall = 0;         ///< its facet lies along the plane
};

std::vector<EdgeRecord> records(const NodeLayout& layout, const std::vector<RimEdge>& edges) {
  std::vector<EdgeRecord> result;
  for (const RimEdge& e : edges) {
    const Vector3<double> from = layout.position(e.nodes[0]), to = layout.position(e.nodes[1]);
    const bool is_along_wall = e.plane && std::abs(e.normal[static_cast<std::size_t>(*e.plane)]) > along_plane;
    result.push_back({layout.global_node(e.nodes[0]), layout.global_node(e.nodes[1]), e.plane.value_or(-1), from, to,
                      layout.order == 1 ? moment<1>(layout, e) : moment<2>(layout, e), norm(to - from),
                      is_along_wall ? 1 : 0});
  }
  return result;
}

/// A loop of the rim, with its sums.
struct Loop {
  int num_edges = 0;
  Vector3<double> sum_of_starts{}, moment{};
  std::array<std::optional<double>, 3> plane;  ///< the place of the plane in each direction
  std::optional<UnknownLid> parallel;          ///< two planes in one direction
  std::vector<EdgeRecord> held;
  double length = 0.0;
  bool slides_along_walls = false;
  void add(const EdgeRecord& e) {
    ++num_edges;
    length += e.length;
    slides_along_walls = slides_along_walls || e.is_along_wall != 0;
    sum_of_starts = sum_of_starts + e.X;
    moment = moment + e.moment;
    if (e.plane < 0) {
      held.push_back(e);
      return;
    }
    const auto k = static_cast<std::size_t>(e.plane);
    if (plane[k] && std::abs(*plane[k] - e.X[k]) > loop_flatness * (norm(e.X) + e.length)) {
      parallel = UnknownLid{e.plane, {*plane[k], e.X[k]}};
    }
    plane[k] = e.X[k];
  }
  bool slides() const {
    return std::ranges::any_of(plane, [](const auto& place) { return place.has_value(); });
  }
};

/// Held edges of a loop that follow one another, in the order of the loop.
using Chain = std::vector<EdgeRecord>;

/// The places that the planes of sliding edges fix.
std::array<bool, 3> planes_at(const Loop& loop, const Vector3<double>& x) {
  std::array<bool, 3> result{};
  for (std::size_t k = 0; k < 3; ++k) {
    result[k] = loop.plane[k] && std::abs(x[k] - *loop.plane[k]) <= loop_flatness * (norm(x) + loop.length);
  }
  return result;
}

/// The chains of the edges that are held outside of the planes in which others slide; nothing if they meet themselves.
std::optional<std::vector<Chain>> chains_of(const Loop& loop) {
  std::map<PetscInt, EdgeRecord> by_start;
  std::set<PetscInt> ends;
  for (const EdgeRecord& edge : loop.held) {
    const auto at_start = planes_at(loop, edge.X), at_end = planes_at(loop, edge.end_X);
    bool slides_too = false;
    for (std::size_t k = 0; k < 3; ++k) slides_too = slides_too || (at_start[k] && at_end[k]);
    if (slides_too) continue;
    if (!by_start.try_emplace(edge.start, edge).second) return std::nullopt;
    ends.insert(edge.end);
  }
  std::vector<Chain> chains;
  std::size_t num_chained = 0;
  for (const auto& [start, first] : by_start) {
    if (ends.contains(start)) continue;
    Chain& chain = chains.emplace_back();
    for (auto at = by_start.find(start); at != by_start.end(); at = by_start.find(chain.back().end)) {
      chain.push_back(at->second);
    }
    num_chained += chain.size();
  }
  if (num_chained != by_start.size()) return std::nullopt;  // a ring has no start
  return chains;
}

/// The place in direction k of the plane in which a chain lies.
std::optional<double> place_of(const Loop& loop, const Chain& chain, std::size_t k) {
  const double place = chain.front().X[k];
  const bool is_flat = std::ranges::all_of(chain, [&](const EdgeRecord& edge) {
    return std::abs(edge.end_X[k] - place) <= loop_flatness * (norm(edge.end_X) + loop.length);
  });
  return is_flat ? std::optional(place) : std::nullopt;
}

/// The way on which the lid of a chain ends, from the chain's end to its start, in the planes of sliding edges there.
std::optional<std::vector<Vector3<double>>> way_back(const Loop& loop, const Chain& chain) {
  const Vector3<double> from = chain.back().end_X, to = chain.front().X;
  const auto at_from = planes_at(loop, from), at_to = planes_at(loop, to);
  for (std::size_t k = 0; k < 3; ++k) {
    if (at_from[k] && at_to[k]) return std::vector{from, to};
  }
  // Two planes, and the lid's across their line.
  Vector3<double> corner = from;
  for (std::size_t k = 0; k < 3; ++k) {
    if (at_from[k]) continue;
    if (at_to[k]) {
      corner[k] = to[k];
    } else if (const auto place = place_of(loop, chain, k)) {
      corner[k] = *place;
    } else {
      return std::nullopt;
    }
  }
  return std::vector{from, corner, to};
}

/// The sum of apex . moment over the lids of a loop: that of each chain of held edges, plane, and the rest in the
/// planes in which edges slide. Without these, the one to the middle of the loop.
std::variant<double, UnknownLid> moments_of_lids(const Loop& loop) {
  if (loop.parallel) return *loop.parallel;
  Vector3<double> apex{}, rest = loop.moment;
  for (std::size_t k = 0; k < 3; ++k) apex[k] = loop.plane[k].value_or(loop.sum_of_starts[k] / loop.num_edges);
  double total = 0.0;
  if (loop.slides()) {
    const auto chains = chains_of(loop);
    if (!chains) return UnknownLid{};
    for (const Chain& chain : *chains) {
      const auto way = way_back(loop, chain);
      if (!way) return UnknownLid{};
      Vector3<double> moment{};
      for (const EdgeRecord& edge : chain) moment = moment + edge.moment;
      for (std::size_t i = 1; i < way->size(); ++i) moment = moment + cross((*way)[i - 1], (*way)[i]);
      // Any place in the lid's plane; a lid that bends has none.
      const Vector3<double> place = chain.front().X;
      const auto height = [&](const Vector3<double>& x) { return std::abs(dot(moment, x - place)); };
      const double rounding = std::sqrt(loop_flatness) * norm(moment) * loop.length;
      if (std::ranges::any_of(chain, [&](const EdgeRecord& edge) { return height(edge.end_X) > rounding; })) {
        return UnknownLid{};
      }
      total += dot(place, moment);
      rest = rest - moment;
    }
  }
  return total + dot(apex, rest);
}

/// The loops of the rim, on every rank.
std::vector<Loop> loops_of(const NodeLayout& layout, const std::vector<RimEdge>& edges) {
  const auto all = gathered(layout.comm, records(layout, edges));
  std::map<PetscInt, std::size_t> number;
  for (const EdgeRecord& e : all) {
    number.try_emplace(e.start, number.size());
    number.try_emplace(e.end, number.size());
  }
  DisjointSets sets(number.size());
  for (const EdgeRecord& e : all) sets.join(number[e.start], number[e.end]);
  std::map<std::size_t, Loop> by_root;
  for (const EdgeRecord& e : all) by_root[sets.root(number[e.start])].add(e);
  std::vector<Loop> loops;
  for (const auto& [root, loop] : by_root) loops.push_back(loop);
  return loops;
}

}  // namespace

std::vector<RimEdge> rim_edges(const NodeLayout& layout, const FacetList& facets) {
  struct Met {
    RimEdge edge;
    int balance = 0;  // facets on its left minus those on its right, in the direction of ascending nodes
  };
  std::map<std::pair<PetscInt, PetscInt>, Met> met;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = std::span(facets.nodes).subspan(f * facets.nodes_per_facet, facets.nodes_per_facet);
    for (int e = 0; e < 3; ++e) {
      const PetscInt a = nodes[e], b = nodes[(e + 1) % 3];
      const bool ascends = layout.global_node(a) < layout.global_node(b);
      // All facets at a node are in the list of its owner.
      if ((ascends ? a : b) >= layout.num_owned_nodes) continue;
      auto& [edge, balance] = met[std::minmax(a, b)];
      balance += ascends ? 1 : -1;
      edge.nodes = {a, b, layout.order == 2 ? nodes[3 + e] : -1};
      if (!ascends) std::swap(edge.nodes[0], edge.nodes[1]);
      const Vector3<double> X = layout.position(nodes[0]);
      edge.normal = unit(cross(layout.position(nodes[1]) - X, layout.position(nodes[2]) - X));
    }
  }
  std::vector<RimEdge> rim;
  for (auto& [ends, of] : met) {
    if (of.balance == 0) continue;
    if (of.balance < 0) std::swap(of.edge.nodes[0], of.edge.nodes[1]);
    rim.push_back(of.edge);
  }
  return rim;
}

Rim classify(const NodeLayout& layout, std::vector<RimEdge>& edges, const PrescribedSamples& prescribed) {
  Rim worst = Rim::none;
  for (RimEdge& edge : edges) worst = std::max(worst, classify_edge(layout, edge, prescribed));
  return static_cast<Rim>(static_cast<int>(maximum(layout.comm, static_cast<double>(worst))));
}

std::vector<std::array<double, 3>> places_of(Rim kind, const NodeLayout& layout, std::vector<RimEdge> edges,
                                             const PrescribedSamples& prescribed) {
  std::vector<std::array<double, 3>> places;
  for (RimEdge& edge : edges) {
    if (classify_edge(layout, edge, prescribed) != kind) continue;
    const Vector3<double> a = layout.position(edge.nodes[0]), b = layout.position(edge.nodes[1]);
    places.push_back(0.5 * (a + b));
  }
  places = gathered(layout.comm, places);
  std::ranges::sort(places);
  return places;
}

// A lid in planes has its vector area, half the sum of the moments, along their normals.
bool planes_close(const NodeLayout& layout, const std::vector<RimEdge>& edges) {
  for (const Loop& loop : loops_of(layout, edges)) {
    if (!loop.held.empty() || !loop.slides_along_walls) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!loop.plane[k] && std::abs(loop.moment[k]) > no_area * loop.length * loop.length) return false;
    }
  }
  return true;
}

std::variant<double, UnknownLid> volume_behind(const NodeLayout& layout, const FacetList& facets,
                                               const std::vector<RimEdge>& edges) {
  double volume =
      sum(layout.comm, layout.order == 1 ? third_of_flux<1>(layout, facets) : third_of_flux<2>(layout, facets));
  for (const Loop& loop : loops_of(layout, edges)) {
    const auto moments = moments_of_lids(loop);
    if (const auto* unknown = std::get_if<UnknownLid>(&moments)) return *unknown;
    volume -= std::get<double>(moments) / 6.0;
  }
  return -volume;
}

}  // namespace pliant
