#include "energy/constraint/tied_surfaces.hpp"

#include "fem/element.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace pliant {
namespace {

/// Weights that vanish where there is no gap.
constexpr double negligible = 1e-13;

std::span<const PetscInt> nodes_of_facet(const FacetList& list, PetscInt facet) {
  return std::span(list.nodes)
      .subspan(static_cast<std::size_t>(facet * list.nodes_per_facet), static_cast<std::size_t>(list.nodes_per_facet));
}

/// The mean over all ranks. Collective.
double mean_edge(const NodeLayout& layout, const FacetList& list) {
  double length = 0.0;
  PetscInt64 number = 0;
  for (PetscInt f = 0; f < list.size(); ++f) {
    if (!list.is_owned[f]) continue;
    const auto nodes = nodes_of_facet(list, f);
    for (const auto& [i, j] : triangle_edges) length += norm(layout.position(nodes[i]) - layout.position(nodes[j]));
    number += 3;
  }
  return sum(layout.comm, length) / static_cast<double>(sum(layout.comm, number));
}

/// The facets of all ranks, on every rank. Collective.
std::vector<FacetOfCell> all_facets(const NodeLayout& layout, const FacetsWithCells& surface) {
  std::vector<FacetOfCell> mine;
  for (PetscInt f = 0; f < surface.facets.size(); ++f) {
    if (!surface.facets.is_owned[f]) continue;
    const auto of_facet = nodes_of_facet(surface.facets, f).first(3);
    const auto of_cell = layout.nodes_of_cell(surface.cells[static_cast<std::size_t>(f)]);
    FacetOfCell& facet = mine.emplace_back();
    facet.nodes_per_cell = layout.nodes_per_cell;
    for (std::size_t a = 0; a < of_cell.size(); ++a) {
      facet.nodes[a] = layout.global_node(of_cell[a]);
      facet.positions[a] = layout.position(of_cell[a]);
      if (a < 4 && std::ranges::find(of_facet, of_cell[a]) == of_facet.end()) {
        facet.opposite = static_cast<std::int32_t>(a);
      }
    }
  }
  return gathered(layout.comm, mine);
}

/// The global nodes of all facets of a surface, on every rank. Collective.
std::set<PetscInt> all_nodes(const NodeLayout& layout, const FacetList& list) {
  std::set<PetscInt> mine;
  for (const PetscInt n : list.nodes) mine.insert(layout.global_node(n));
  const auto all = gathered(layout.comm, std::vector<PetscInt>(mine.begin(), mine.end()));
  return {all.begin(), all.end()};
}

/// The rows of this rank's nodes.
class TieBuilder {
 public:
  TieBuilder(const NodeLayout& layout, const FacetList& dependent, const IndependentSurface& onto,
             const std::set<PetscInt>& shared, double edge, double tolerance)
      : layout_(layout), dependent_(dependent), onto_(onto), shared_(shared), edge_(edge), tolerance_(tolerance) {
    for (const PetscInt n : dependent.nodes) {
      if (!distances_.contains(n)) distances_[n] = distance(n);
    }
  }

  std::vector<TiedNode> rows() {
    for (PetscInt f = 0; f < dependent_.size(); ++f) add(nodes_of_facet(dependent_, f));
    std::vector<TiedNode> result;
    for (const auto& [n, d] : distances_) {
      if (!owns(n) || d > tolerance_) continue;
      TiedNode& tied = result.emplace_back();
      const auto around = around_.find(n);
      if (around != around_.end()) {
        tied = row_of(around->second);
      } else {
        interpolate(layout_.position(n), tied);
      }
      tied.node = layout_.global_node(n);
      tied.is_shared = shared_.contains(tied.node);
      std::erase(tied.neighbours, tied.node);
    }
    return result;
  }

  /// Counts, gaps and distances of this rank's nodes.
  void measure(SurfaceTie& tie) const {
    for (const auto& [n, d] : distances_) {
      if (!owns(n)) continue;
      if (shared_.contains(layout_.global_node(n))) {
        ++tie.num_shared;
      } else if (d <= tolerance_) {
        tie.largest_gap = std::max(tie.largest_gap, d);
      } else {
        ++tie.num_free;
        if (d >= tie.least_distance) continue;
        tie.least_distance = d;
        tie.nearest_free = layout_.position(n);
      }
    }
  }

 private:
  /// What the facets around a node give.
  struct Around {
    double area = 0.0;
    bool has_share = false;
    std::map<PetscInt, double> weighted;  // A_e w
    std::set<PetscInt> nodes;
  };

  bool owns(PetscInt n) const { return n < layout_.num_owned_nodes; }

  double distance(PetscInt n) const {
    if (shared_.contains(layout_.global_node(n))) return 0.0;
    const auto near = onto_.nearest(layout_.position(n), tolerance_);
    return near ? near->distance : onto_.distance(layout_.position(n));
  }

  void add(std::span<const PetscInt> facet) {
    if (std::ranges::none_of(facet, [&](PetscInt n) { return owns(n); })) return;
    if (std::ranges::any_of(facet, [&](PetscInt n) { return distances_.at(n) > tolerance_; })) return;
    std::vector<Vector3<double>> X;
    for (const PetscInt n : facet) X.push_back(layout_.position(n));
    const auto projection = project(X, onto_, tolerance_);
    if (!projection) return;
    for (std::size_t k = 0; k < facet.size(); ++k) {
      if (!owns(facet[k])) continue;
      Around& around = around_[facet[k]];
      around.area += projection->area;
      around.has_share = facet.size() == 3 || k >= 3;
      for (const auto& [node, weight] : projection->weights[k]) around.weighted[node] += projection->area * weight;
      for (const PetscInt n : facet) around.nodes.insert(layout_.global_node(n));
    }
  }

  static TiedNode row_of(const Around& around) {
    TiedNode tied{0, around.area, false, around.has_share, {}, {around.nodes.begin(), around.nodes.end()}};
    for (const auto& [node, weighted] : around.weighted) {
      if (std::abs(weighted) > negligible * around.area) tied.weights.push_back({node, weighted / around.area});
    }
    return tied;
  }

  /// For a node without a facet that is tied as a whole.
  void interpolate(const Vector3<double>& X, TiedNode& tied) const {
    const auto place = onto_.nearest(X, tolerance_);
    const FacetOfCell& facet = onto_.facet(place->facet);
    const auto N = onto_.shape_functions(place->facet, X);
    tied.area = edge_ * edge_;
    for (std::size_t j = 0; j < static_cast<std::size_t>(facet.nodes_per_cell); ++j) {
      if (std::abs(N[j]) > negligible) tied.weights.push_back({facet.nodes[j], N[j]});
    }
  }

  const NodeLayout& layout_;
  const FacetList& dependent_;
  const IndependentSurface& onto_;
  const std::set<PetscInt>& shared_;
  double edge_, tolerance_;               // the mean edge of the dependent surface
  std::map<PetscInt, double> distances_;  // of local nodes
  std::map<PetscInt, Around> around_;     // of owned nodes
};

/// On every rank, by ascending node. Collective.
std::vector<TiedNode> gathered_rows(MPI_Comm comm, const std::vector<TiedNode>& mine) {
  struct Head {
    PetscInt node;
    double area;
    std::size_t is_shared, has_share, num_weights, num_neighbours;
  };
  std::vector<Head> my_heads;
  std::vector<NodeWeight> my_weights;
  std::vector<PetscInt> my_neighbours;
  for (const TiedNode& t : mine) {
    my_heads.push_back(
        {t.node, t.area, t.is_shared ? 1u : 0u, t.has_share ? 1u : 0u, t.weights.size(), t.neighbours.size()});
    my_weights.insert(my_weights.end(), t.weights.begin(), t.weights.end());
    my_neighbours.insert(my_neighbours.end(), t.neighbours.begin(), t.neighbours.end());
  }
  const auto heads = gathered(comm, my_heads);
  const auto weights = gathered(comm, my_weights);
  const auto neighbours = gathered(comm, my_neighbours);
  std::vector<TiedNode> result;
  auto weight = weights.begin();
  auto neighbour = neighbours.begin();
  for (const Head& head : heads) {
    TiedNode& t = result.emplace_back();
    t.node = head.node;
    t.area = head.area;
    t.is_shared = head.is_shared != 0;
    t.has_share = head.has_share != 0;
    t.weights.assign(weight, weight + static_cast<std::ptrdiff_t>(head.num_weights));
    t.neighbours.assign(neighbour, neighbour + static_cast<std::ptrdiff_t>(head.num_neighbours));
    weight += static_cast<std::ptrdiff_t>(head.num_weights);
    neighbour += static_cast<std::ptrdiff_t>(head.num_neighbours);
  }
  std::ranges::sort(result, {}, &TiedNode::node);
  return result;
}

/// Sums and extremes over all ranks. Collective.
void reduce(MPI_Comm comm, SurfaceTie& tie) {
  struct Nearest {
    double distance;
    Vector3<double> X;
  };
  const auto all = gathered(comm, std::array{Nearest{tie.least_distance, tie.nearest_free}});
  const auto least = std::ranges::min_element(all, {}, &Nearest::distance);
  tie.least_distance = least->distance;
  tie.nearest_free = least->X;
  tie.largest_gap = maximum(comm, tie.largest_gap);
  tie.num_shared = static_cast<std::size_t>(sum(comm, static_cast<PetscInt64>(tie.num_shared)));
  tie.num_free = static_cast<std::size_t>(sum(comm, static_cast<PetscInt64>(tie.num_free)));
}

}  // namespace

SurfaceTie tie_surfaces(const NodeLayout& layout, const FacetList& dependent, const FacetsWithCells& independent,
                        std::optional<double> tolerance, std::size_t source) {
  SurfaceTie tie;
  tie.source = source;
  const double edge = mean_edge(layout, dependent);
  tie.tolerance = tolerance.value_or(default_tie_tolerance * std::max(edge, mean_edge(layout, independent.facets)));
  const auto facets = all_facets(layout, independent);
  const auto shared = all_nodes(layout, independent.facets);
  std::vector<TiedNode> mine;
  on_every_rank(layout.comm, [&] {
    const IndependentSurface onto(facets);
    TieBuilder builder(layout, dependent, onto, shared, edge, tie.tolerance);
    mine = builder.rows();
    builder.measure(tie);
  });
  tie.nodes = gathered_rows(layout.comm, mine);
  reduce(layout.comm, tie);
  return tie;
}

std::vector<PetscInt> nodes_of(const SurfaceTie& tie) {
  std::set<PetscInt> nodes;
  for (const TiedNode& tied : tie.nodes) {
    nodes.insert(tied.node);
    for (const NodeWeight& w : tied.weights) nodes.insert(w.node);
  }
  return {nodes.begin(), nodes.end()};
}

}  // namespace pliant
