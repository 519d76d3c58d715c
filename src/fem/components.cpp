#include "fem/components.hpp"

#include "base/limits.hpp"
#include "base/vector3.hpp"
#include "fem/element.hpp"
#include "mesh/disjoint_sets.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/exchange.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace pliant {
namespace {

using Position = Vector3<double>;

/// Labels of nodes: the lowest global number owned by this rank among the nodes that its own cells connect. Stored as
/// doubles, which hold them exactly.
std::vector<double> labels_here(const NodeLayout& layout, DisjointSets& sets) {
  const auto num_local = static_cast<std::size_t>(layout.num_local_nodes);
  std::vector<double> lowest(num_local, infinity);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    double& label = lowest[sets.root(static_cast<std::size_t>(n))];
    label = std::min(label, static_cast<double>(layout.global_node(n)));
  }
  std::vector<double> labels(num_local);
  for (std::size_t n = 0; n < num_local; ++n) labels[n] = lowest[sets.root(n)];
  return labels;
}

/// The owners' labels of all local nodes. Collective.
std::vector<double> owners_labels(const NodeLayout& layout, const std::vector<double>& here) {
  const Handle<Vec> x = make_vector(layout);
  {
    const ArrayView values(x.get());
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) values[3 * n] = here[static_cast<std::size_t>(n)];
  }
  update_ghosts(x.get());
  const ConstGhostedView values(x.get());
  std::vector<double> labels(static_cast<std::size_t>(layout.num_local_nodes));
  for (std::size_t n = 0; n < labels.size(); ++n) labels[n] = values.span()[3 * n];
  return labels;
}

/// Pairs of labels that some rank knows to belong to one component.
std::vector<double> connections_here(const NodeLayout& layout, const std::vector<double>& owners, DisjointSets& sets) {
  std::map<std::size_t, double> first;
  std::set<std::pair<double, double>> pairs;
  for (std::size_t n = 0; n < static_cast<std::size_t>(layout.num_local_nodes); ++n) {
    const double known = first.try_emplace(sets.root(n), owners[n]).first->second;
    pairs.insert({known, owners[n]});
  }
  std::vector<double> result;
  for (const auto& [a, b] : pairs) result.insert(result.end(), {a, b});
  return result;
}

/// Numbers the labels in ascending order of the lowest label of each component.
std::map<double, int> numbers_of(const std::vector<double>& pairs, int& count) {
  std::map<double, std::size_t> place;
  for (const double label : pairs) place.try_emplace(label, place.size());
  DisjointSets sets(place.size());
  for (std::size_t i = 0; i + 1 < pairs.size(); i += 2) sets.join(place.at(pairs[i]), place.at(pairs[i + 1]));
  std::map<std::size_t, int> number_of_root;
  std::map<double, int> numbers;
  for (const auto& [label, p] : place) {
    numbers[label] = number_of_root.try_emplace(sets.root(p), static_cast<int>(number_of_root.size())).first->second;
  }
  count = static_cast<int>(number_of_root.size());
  return numbers;
}

Position current(const NodeLayout& layout, std::span<const double> u, PetscInt n) {
  return {layout.coordinates[3 * n] + u[3 * n], layout.coordinates[3 * n + 1] + u[3 * n + 1],
          layout.coordinates[3 * n + 2] + u[3 * n + 2]};
}

struct ComponentBox {
  Position low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};

  void include(const Position& x) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], x[i]);
      high[i] = std::max(high[i], x[i]);
    }
  }
  bool holds(const Position& x) const {
    return x[0] >= low[0] && x[1] >= low[1] && x[2] >= low[2] && x[0] <= high[0] && x[1] <= high[1] && x[2] <= high[2];
  }
  bool meets(const ComponentBox& other) const {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(low[i] < other.high[i] && other.low[i] < high[i])) return false;
    }
    return true;
  }
};

/// Sums over the nodes of each component on all ranks. Collective.
std::vector<ComponentBox> boxes_of(const NodeLayout& layout, const Components& components, std::span<const double> u) {
  const auto count = static_cast<std::size_t>(components.count);
  std::vector<ComponentBox> boxes(count);
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    boxes[static_cast<std::size_t>(components.of_node[n])].include(current(layout, u, n));
  }
  std::vector<double> least;  // minima of low and of -high
  for (const ComponentBox& box : boxes) {
    least.insert(least.end(), box.low.begin(), box.low.end());
    for (const double x : box.high) least.push_back(-x);
  }
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, least.data(), static_cast<int>(least.size()), MPI_DOUBLE, MPI_MIN, layout.comm));
  for (std::size_t b = 0; b < count; ++b) {
    for (std::size_t i = 0; i < 3; ++i) {
      boxes[b].low[i] = least[6 * b + i];
      boxes[b].high[i] = -least[6 * b + 3 + i];
    }
  }
  return boxes;
}

struct Candidate {
  Position x;
  int component;
};

/// The other components that each may penetrate: those whose boxes meet its own.
std::vector<std::vector<int>> met_components(const std::vector<ComponentBox>& boxes,
                                             std::span<const char> are_kept_apart) {
  std::vector<std::vector<int>> met(boxes.size());
  for (std::size_t a = 0; a < boxes.size(); ++a) {
    for (std::size_t b = 0; b < boxes.size(); ++b) {
      if (a == b || !boxes[a].meets(boxes[b])) continue;
      if (!are_kept_apart.empty() && are_kept_apart[a * boxes.size() + b] != 0) continue;
      met[a].push_back(static_cast<int>(b));
    }
  }
  return met;
}

bool is_left_out(const Components& components, PetscInt cell) {
  return !components.is_left_out.empty() && components.is_left_out[static_cast<std::size_t>(cell)] != 0;
}

std::vector<char> nodes_of_cells_left_out(const NodeLayout& layout, const Components& components) {
  std::vector<char> result(static_cast<std::size_t>(layout.num_local_nodes), 0);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (!is_left_out(components, c)) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) result[static_cast<std::size_t>(n)] = 1;
  }
  return result;
}

/// Nodes of all ranks in the box of a component that theirs meets, in ascending order of x. Collective.
std::vector<Candidate> candidates(const NodeLayout& layout, const Components& components, std::span<const double> u,
                                  const std::vector<ComponentBox>& boxes, const std::vector<std::vector<int>>& met,
                                  std::size_t most) {
  const std::vector<char> are_left_out = nodes_of_cells_left_out(layout, components);
  std::vector<Candidate> mine;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const int a = components.of_node[n];
    if (met[a].empty() || are_left_out[static_cast<std::size_t>(n)] != 0) continue;
    const Position x = current(layout, u, n);
    if (std::ranges::none_of(met[a], [&](int b) { return boxes[b].holds(x); })) continue;
    mine.push_back({x, a});
  }
  const std::size_t stride = 1 + mine.size() / most;
  std::vector<Candidate> chosen;
  for (std::size_t i = 0; i < mine.size(); i += stride) chosen.push_back(mine[i]);
  std::vector<Candidate> result = gathered(layout.comm, chosen);
  std::ranges::stable_sort(result, {}, [](const Candidate& c) { return c.x[0]; });
  return result;
}

using Side = std::array<PetscInt, 3>;  // global nodes, ascending

Side side_of(const NodeLayout& layout, PetscInt cell, std::size_t opposite) {
  const auto nodes = layout.nodes_of_cell(cell);
  Side side{};
  for (std::size_t a = 0; a < 3; ++a) side[a] = layout.global_node(nodes[(opposite + 1 + a) % 4]);
  std::ranges::sort(side);
  return side;
}

/// Sides of only one cell. The owner of a node has all cells at it, and is asked about the sides whose first node it
/// is. Collective.
std::vector<unsigned char> outer_sides(const NodeLayout& layout) {
  std::map<Side, int> cells_at;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    for (std::size_t i = 0; i < 4; ++i) ++cells_at[side_of(layout, c, i)];
  }
  const auto is_outer = [&](const Side& side) { return static_cast<char>(cells_at.at(side) == 1); };
  std::vector<PetscInt> first(static_cast<std::size_t>(num_ranks(layout.comm)));
  check_mpi(MPI_Allgather(&layout.first_global_node, 1, MPIU_INT, first.data(), 1, MPIU_INT, layout.comm));
  std::vector<std::vector<Side>> questions(first.size());
  std::vector<std::vector<std::pair<PetscInt, std::size_t>>> places(first.size());  // of them: cell, opposite corner
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Side side = side_of(layout, c, i);
      if (is_outer(side) == 0) continue;
      const auto owner = static_cast<std::size_t>(std::ranges::upper_bound(first, side[0]) - first.begin() - 1);
      questions[owner].push_back(side);
      places[owner].emplace_back(c, i);
    }
  }
  std::vector<unsigned char> result(static_cast<std::size_t>(layout.num_owned_cells), 0);
  const std::vector<char> answers = answered(layout.comm, questions, is_outer);
  auto next = answers.begin();
  for (const auto& list : places) {
    for (const auto& [cell, corner] : list) {
      if (*next++ != 0) result[static_cast<std::size_t>(cell)] |= static_cast<unsigned char>(1U << corner);
    }
  }
  return result;
}

/// The nodes of outer sides, those of other ranks included. Collective.
std::vector<char> nodes_of_sides(const NodeLayout& layout, std::span<const unsigned char> outer) {
  const Handle<Vec> number = make_vector(layout);
  {
    const GhostedView values(number.get());
    for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
      const auto nodes = layout.nodes_of_cell(c);
      for (std::size_t i = 0; i < 4; ++i) {
        if ((outer[static_cast<std::size_t>(c)] >> i & 1U) == 0) continue;
        for (std::size_t a = 0; a < 4; ++a) values.span()[3 * nodes[a]] += a == i ? 0.0 : 1.0;
      }
    }
  }
  check(VecGhostUpdateBegin(number.get(), ADD_VALUES, SCATTER_REVERSE));
  check(VecGhostUpdateEnd(number.get(), ADD_VALUES, SCATTER_REVERSE));
  update_ghosts(number.get());
  const ConstGhostedView values(number.get());
  std::vector<char> is_outer;
  for (PetscInt n = 0; n < layout.num_local_nodes; ++n) is_outer.push_back(values.span()[3 * n] > 0.0 ? 1 : 0);
  return is_outer;
}

/// Which of its parts a tetrahedron has on the surface: sides (bit i: opposite to corner i) and corners.
struct OuterParts {
  unsigned char sides = 0;
  std::array<bool, 4> corners{};
};

/// A lower bound of the depth of x below the surface in the tetrahedron that contains it [m], at most `most`; nothing
/// if it is outside. Where no side is on the surface, an edge between two corners that are on it may be, or one corner.
std::optional<double> depth_in(const std::array<Position, 4>& corners, const OuterParts& outer, const Position& x,
                               double most) {
  constexpr double rounding = 1e-9;  // relative to the height
  double depth = most;
  std::array<double, 4> parts{};  // barycentric
  for (std::size_t i = 0; i < 4; ++i) {
    const Position &a = corners[(i + 1) % 4], &b = corners[(i + 2) % 4], &c = corners[(i + 3) % 4];
    const Position n = cross(b - a, c - a);
    const double height = dot(n, corners[i] - a);
    if (height == 0.0) return std::nullopt;
    parts[i] = dot(n, x - a) / height;
    if (parts[i] < -rounding) return std::nullopt;
    if ((outer.sides >> i & 1U) != 0) depth = std::min(depth, parts[i] * std::abs(height) / norm(n));
  }
  if (outer.sides != 0) return depth;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      if (outer.corners[i] && outer.corners[j]) {
        depth = std::min(depth, most * (1.0 - parts[i] - (i == j ? 0.0 : parts[j])));
      }
    }
  }
  return depth;
}

/// By how much the sides of a cell may lie within the straight ones [m]: a side of which all edges are bent by d
/// deviates by 4/3 d in its middle.
double bend_of_sides(const NodeLayout& layout, std::span<const double> u, std::span<const PetscInt> nodes,
                     const std::array<Position, 4>& corners) {
  double largest = 0.0;
  for (std::size_t e = 0; 4 + e < nodes.size(); ++e) {
    const auto& [i, j] = tet_edges[e];
    const Position straight = 0.5 * (corners[static_cast<std::size_t>(i)] + corners[static_cast<std::size_t>(j)]);
    largest = std::max(largest, norm(current(layout, u, nodes[4 + e]) - straight));
  }
  return 4.0 / 3.0 * largest;
}

}  // namespace

Components connected_components(const NodeLayout& layout) {
  DisjointSets sets(static_cast<std::size_t>(layout.num_local_nodes));
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    for (const PetscInt n : nodes) sets.join(static_cast<std::size_t>(nodes[0]), static_cast<std::size_t>(n));
  }
  const std::vector<double> owners = owners_labels(layout, labels_here(layout, sets));
  Components result;
  const auto numbers = numbers_of(gathered(layout.comm, connections_here(layout, owners, sets)), result.count);
  for (const double label : owners) result.of_node.push_back(numbers.at(label));
  if (result.count > 1) {
    result.outer_sides = outer_sides(layout);
    result.is_outer = nodes_of_sides(layout, result.outer_sides);
  }
  return result;
}

std::vector<std::vector<PetscInt>> free_components(const NodeLayout& layout,
                                                   const std::function<bool(PetscInt node)>& is_held) {
  const Components components = connected_components(layout);
  std::vector<double> held(static_cast<std::size_t>(components.count), 0.0);
  std::vector<std::vector<PetscInt>> nodes(held.size());
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const auto component = static_cast<std::size_t>(components.of_node[n]);
    nodes[component].push_back(n);
    if (is_held(n)) held[component] = 1.0;
  }
  sum_in_place(layout.comm, held);
  std::vector<std::vector<PetscInt>> free;
  for (std::size_t c = 0; c < nodes.size(); ++c) {
    if (held[c] == 0.0) free.push_back(std::move(nodes[c]));
  }
  return free;
}

void join(Components& components, const NodeLayout& layout, std::span<const PetscInt> nodes) {
  std::vector<double> found(static_cast<std::size_t>(components.count), 0.0);
  for (const PetscInt n : nodes) found[static_cast<std::size_t>(components.of_node[n])] = 1.0;
  sum_in_place(layout.comm, found);
  std::vector<int> number(found.size());
  int first = -1, next = 0;
  for (std::size_t c = 0; c < found.size(); ++c) {
    const bool is_joined = found[c] > 0.0;
    if (is_joined && first < 0) first = next;
    const bool is_new = !is_joined || first == next;
    number[c] = is_new ? next : first;
    if (is_new) ++next;
  }
  components.count = next;
  for (int& c : components.of_node) c = number[static_cast<std::size_t>(c)];
}

std::optional<Overlap> deepest_overlap(const NodeLayout& layout, const Components& components,
                                       std::span<const double> u, std::size_t most_nodes,
                                       std::span<const char> are_kept_apart) {
  if (components.count < 2) return std::nullopt;
  const std::vector<ComponentBox> boxes = boxes_of(layout, components, u);
  const std::vector<std::vector<int>> met = met_components(boxes, are_kept_apart);
  const std::vector<Candidate> points = candidates(layout, components, u, boxes, met, most_nodes);
  if (points.empty()) return std::nullopt;
  std::vector<char> may_hold(boxes.size(), 0);
  for (const std::vector<int>& others : met) {
    for (const int b : others) may_hold[static_cast<std::size_t>(b)] = 1;
  }
  constexpr double least_part = 0.05;  // relative to the cell: two meshes of one curved surface differ by less
  // A node on a side, edge or corner is in several cells, on several ranks: the smallest of their depths counts.
  std::vector<double> depths(points.size(), infinity);
  std::vector<int> holders(points.size(), -1);
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    if (is_left_out(components, c)) continue;
    const auto nodes = layout.nodes_of_cell(c);
    const int component = components.of_node[nodes[0]];
    if (may_hold[static_cast<std::size_t>(component)] == 0) continue;
    std::array<Position, 4> corners{};
    ComponentBox box;
    for (std::size_t a = 0; a < 4; ++a) {
      corners[a] = current(layout, u, nodes[a]);
      box.include(corners[a]);
    }
    const double size = norm(box.high - box.low), bend = bend_of_sides(layout, u, nodes, corners);
    auto point = std::ranges::lower_bound(points, box.low[0], {}, [](const Candidate& p) { return p.x[0]; });
    for (; point != points.end() && point->x[0] <= box.high[0]; ++point) {
      if (!box.holds(point->x)) continue;
      if (std::ranges::find(met[static_cast<std::size_t>(point->component)], component) ==
          met[static_cast<std::size_t>(point->component)].end()) {
        continue;
      }
      OuterParts outer{components.outer_sides[static_cast<std::size_t>(c)], {}};
      for (std::size_t a = 0; a < 4; ++a) outer.corners[a] = components.is_outer[nodes[a]] != 0;
      const auto depth = depth_in(corners, outer, point->x, size);
      if (!depth) continue;
      const auto p = static_cast<std::size_t>(point - points.begin());
      const double least = *depth - bend;
      depths[p] = std::min(depths[p], least > least_part * size ? least : 0.0);
      holders[p] = std::max(holders[p], component);
    }
  }
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, depths.data(), static_cast<int>(depths.size()), MPI_DOUBLE, MPI_MIN, layout.comm));
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, holders.data(), static_cast<int>(holders.size()), MPI_INT, MPI_MAX, layout.comm));
  Overlap deepest;
  double lowest = infinity;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (!std::isfinite(depths[p]) || depths[p] <= 0.0) continue;
    // Ties between equally deep places are broken independently of the ranks: the lowest along a generic direction
    // wins.
    const double level = dot(Position{1.0, 0.6180339887, 0.3819660113}, points[p].x);
    const double same = 1e-9 * deepest.depth;
    if (depths[p] < deepest.depth - same || (depths[p] <= deepest.depth + same && level >= lowest)) continue;
    lowest = level;
    deepest = {depths[p], points[p].x, points[p].component, holders[p]};
  }
  return deepest.depth > 0.0 ? std::optional(deepest) : std::nullopt;
}

}  // namespace pliant
