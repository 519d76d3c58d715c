#include "energy/shell/shell_bending.hpp"

#include "base/compensated_sum.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace pliant {
namespace {

/// The corners of the triangles of a facet, among its nodes (corners, then mid-edge nodes 01 12 02).
constexpr std::array<std::array<int, 3>, 1> linear_triangles{{{0, 1, 2}}};
constexpr std::array<std::array<int, 3>, 4> quadratic_triangles{{{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};

/// f(local nodes, facet) of each triangle of each facet.
template <class F>
void for_each_triangle(const FacetList& facets, const F& f) {
  const std::span<const std::array<int, 3>> triangles =
      facets.nodes_per_facet == 3 ? std::span<const std::array<int, 3>>(linear_triangles) : quadratic_triangles;
  for (PetscInt facet = 0; facet < facets.size(); ++facet) {
    const auto nodes = facets.nodes_of(facet);
    for (const auto& [a, b, c] : triangles) f(std::array{nodes[a], nodes[b], nodes[c]}, facet);
  }
}

/// The corners of the edge k of a stencil: a, b, and the far ones c and o.
std::array<std::size_t, 4> corners_of(std::size_t edge) {
  return {edge, (edge + 1) % 3, (edge + 2) % 3, 3 + edge};
}

/// The sum of M_kj d_j: the moments about the edges [N m].
std::array<double, 3> moments(const std::array<double, 9>& M, const std::array<double, 3>& d) {
  std::array<double, 3> m{};
  for (std::size_t k = 0; k < 3; ++k) m[k] = M[3 * k] * d[0] + M[3 * k + 1] * d[1] + M[3 * k + 2] * d[2];
  return m;
}

/// The slopes of an angle by the six nodes of a stencil, from those by e, u, v.
std::array<double, 18> by_nodes(std::size_t edge, const std::array<double, 9>& slope) {
  std::array<double, 18> result{};
  const auto [a, b, c, o] = corners_of(edge);
  for (std::size_t i = 0; i < 3; ++i) {
    result[3 * b + i] = slope[i];
    result[3 * c + i] = slope[3 + i];
    result[3 * o + i] = slope[6 + i];
    result[3 * a + i] = -(slope[i] + slope[3 + i] + slope[6 + i]);
  }
  return result;
}

/// H += m d2 theta / dx2 of the six nodes of a stencil.
void add_bend(std::size_t edge, double moment, const SecondOrder<9>& angle, std::array<double, 324>& H) {
  const auto [a, b, c, o] = corners_of(edge);
  const std::array<std::size_t, 3> far{b, c, o};
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) {
      const double entry = moment * angle.bend_of(p, q);
      const std::size_t row = 3 * far[p / 3] + p % 3, column = 3 * far[q / 3] + q % 3;
      const std::size_t row_of_a = 3 * a + p % 3, column_of_a = 3 * a + q % 3;
      H[18 * row + column] += entry;
      H[18 * row_of_a + column] -= entry;
      H[18 * row + column_of_a] -= entry;
      H[18 * row_of_a + column_of_a] += entry;
    }
  }
}

}  // namespace

std::array<std::int64_t, 3> ShellBending::Triangle::sorted() const {
  auto result = nodes;
  std::ranges::sort(result);
  return result;
}

ShellBending::ShellBending(const NodeLayout& layout, const FacetList& facets,
                           const std::function<BendingStiffness(const std::array<double, 3>&)>& stiffness)
    : num_owned_nodes_(layout.num_owned_nodes) {
  double length = 0.0;
  const auto add = [&](const std::array<PetscInt, 3>& nodes, PetscInt facet) {
    if (facets.is_owned[facet] == 0) return;
    Triangle& triangle = triangles_.emplace_back();
    Vector3<double> middle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3<double> X = layout.position(nodes[k]), next = layout.position(nodes[(k + 1) % 3]);
      triangle.nodes[k] = layout.global_node(nodes[k]);
      middle = middle + (1.0 / 3.0) * X;
      length += norm(next - X) / 3.0;
    }
    triangle.stiffness = stiffness(middle);
  };
  on_every_rank(layout.comm, [&] { for_each_triangle(facets, add); });
  triangles_ = gathered(layout.comm, triangles_);
  std::ranges::sort(triangles_, {}, &Triangle::sorted);
  edge_length_ = sum(layout.comm, length) / static_cast<double>(std::max<std::size_t>(triangles_.size(), 1));
  find_neighbours();
  list_patches(layout, facets);
}

void ShellBending::find_neighbours() {
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::pair<std::size_t, std::size_t>>> at_edge;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto ends = std::minmax(triangles_[t].nodes[k], triangles_[t].nodes[(k + 1) % 3]);
      at_edge[ends].emplace_back(t, k);
    }
  }
  neighbours_.assign(triangles_.size(), {-1, -1, -1});
  for (const auto& [ends, sides] : at_edge) {
    if (sides.size() != 2) continue;
    neighbours_[sides[0].first][sides[0].second] = static_cast<std::int64_t>(sides[1].first);
    neighbours_[sides[1].first][sides[1].second] = static_cast<std::int64_t>(sides[0].first);
  }
}

void ShellBending::list_patches(const NodeLayout& layout, const FacetList& facets) {
  patches_.nodes_per_patch = 3;
  for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt /*facet*/) {
    const auto is_owned = [&](PetscInt node) { return node < layout.num_owned_nodes; };
    if (std::ranges::none_of(nodes, is_owned)) return;
    Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) triangle.nodes[k] = layout.global_node(nodes[k]);
    const auto place = std::ranges::lower_bound(triangles_, triangle.sorted(), {}, &Triangle::sorted);
    // All ranks know the corners in the same order.
    for (const std::int64_t node : place->nodes) {
      const auto k = std::ranges::find(triangle.nodes, node) - triangle.nodes.begin();
      patches_.nodes.push_back(nodes[static_cast<std::size_t>(k)]);
    }
    patches_.keys.push_back(place - triangles_.begin());
    patches_.tags.push_back(0);
    const auto first = std::ranges::min_element(triangle.nodes) - triangle.nodes.begin();
    patches_.is_owned.push_back(is_owned(nodes[static_cast<std::size_t>(first)]) ? 1 : 0);
  });
}

bool ShellBending::couples(std::int64_t key, std::int64_t other) const {
  const auto& of_other = triangles_[static_cast<std::size_t>(other)].nodes;
  return std::ranges::any_of(triangles_[static_cast<std::size_t>(key)].nodes,
                             [&](std::int64_t node) { return std::ranges::find(of_other, node) != of_other.end(); });
}

HingeVectors ShellBending::vectors(const Stencil& stencil, std::size_t edge, std::span<const double> X,
                                   std::span<const double> q) {
  const auto [a, b, c, o] = corners_of(edge);
  HingeVectors result;
  const std::array<std::size_t, 3> far{b, c, o};
  const auto start = 3 * static_cast<std::size_t>(stencil.nodes[a]);
  for (std::size_t v = 0; v < 3; ++v) {
    const auto end = 3 * static_cast<std::size_t>(stencil.nodes[far[v]]);
    for (std::size_t i = 0; i < 3; ++i) {
      result[v][i] = (X[end + i] - X[start + i]) + (q[end + i] - q[start + i]);
    }
  }
  return result;
}

ShellBending::Stencil ShellBending::stencil_of(std::size_t number, const std::map<std::int64_t, std::size_t>& place,
                                               const NearPatches& near) const {
  Stencil stencil;
  const auto own = std::span(stencil.nodes).first(3);
  const std::size_t p = place.at(static_cast<std::int64_t>(number));
  std::ranges::copy(near.patches.nodes_of(p), own.begin());
  stencil.is_counted = near.patches.is_owned[p] != 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (neighbours_[number][k] < 0) continue;
    const auto other = place.find(neighbours_[number][k]);
    if (other == place.end()) return {};
    const auto nodes = near.patches.nodes_of(other->second);
    stencil.nodes[3 + k] =
        *std::ranges::find_if(nodes, [&](PetscInt node) { return std::ranges::find(own, node) == own.end(); });
  }
  return stencil;
}

// Whoever owns a node of a patch of four triangles knows them all: each has a node in common with each other.
std::shared_ptr<const PairFeatures> ShellBending::features_of(const NearPatches& near) const {
  auto here = std::make_shared<Seen>();
  std::map<std::int64_t, std::size_t> place;
  for (std::size_t p = 0; p < near.patches.size(); ++p) place.emplace(near.patches.keys[p], p);
  const std::vector<double> unmoved(near.coordinates.size(), 0.0);
  const auto is_here = [&](PetscInt node) { return node >= 0 && near.is_owned(node); };
  for (const auto& [key, p] : place) {
    const auto number = static_cast<std::size_t>(key);
    Stencil stencil = stencil_of(number, place, near);
    if (std::ranges::none_of(stencil.nodes, is_here)) continue;
    HingePatch patch;
    const auto position = [&](PetscInt node) -> Vector3<double> {
      const auto i = 3 * static_cast<std::size_t>(node);
      return {near.coordinates[i], near.coordinates[i + 1], near.coordinates[i + 2]};
    };
    for (std::size_t k = 0; k < 3; ++k) {
      patch.corners[k] = position(stencil.nodes[k]);
      patch.has_other[k] = stencil.nodes[3 + k] >= 0;
      if (patch.has_other[k]) patch.others[k] = position(stencil.nodes[3 + k]);
    }
    const BendingStiffness& stiffness = triangles_[number].stiffness;
    stencil.M = hinge_matrix(patch, stiffness.rigidity, stiffness.poissons_ratio);
    stencil.rest = changes(stencil, near.coordinates, unmoved);
    here->stencils.push_back(stencil);
  }
  return here;
}

const ShellBending::Seen& ShellBending::seen(const NearPatches* near) {
  static const Seen none;
  return near != nullptr && near->features ? static_cast<const Seen&>(*near->features) : none;
}

std::array<double, 3> ShellBending::changes(const Stencil& stencil, std::span<const double> X,
                                            std::span<const double> q) {
  std::array<double, 3> result{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (stencil.nodes[3 + k] < 0) continue;
    result[k] = differentiated_angle<1>(vectors(stencil, k, X, q)).value - stencil.rest[k];
  }
  return result;
}

double ShellBending::value(const LocalStage& stage, std::span<const double> q) const {
  CompensatedSum<double> total;
  for (const Stencil& stencil : seen(stage.near).stencils) {
    if (!stencil.is_counted) continue;
    const auto now = changes(stencil, stage.near->coordinates, q),
               then = changes(stencil, stage.near->coordinates, stage.reference());
    std::array<double, 3> both{};
    for (std::size_t k = 0; k < 3; ++k) both[k] = now[k] + then[k];
    const auto m = moments(stencil.M, both);
    for (std::size_t k = 0; k < 3; ++k) total.add(0.5 * (now[k] - then[k]) * m[k]);
  }
  return total.total();
}

double ShellBending::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  CompensatedSum<double> total;
  for (const Stencil& stencil : seen(at.near).stencils) {
    if (!stencil.is_counted) continue;
    const auto d = changes(stencil, at.near->coordinates, q);
    const auto m = moments(stencil.M, d);
    for (std::size_t k = 0; k < 3; ++k) total.add(0.5 * d[k] * m[k]);
  }
  return total.total();
}

void ShellBending::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  for (const Stencil& stencil : seen(stage.near).stencils) {
    std::array<Differentiated<9, 1>, 3> angles;
    std::array<double, 3> d{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (stencil.nodes[3 + k] < 0) continue;
      angles[k] = differentiated_angle<1>(vectors(stencil, k, stage.near->coordinates, q));
      d[k] = angles[k].value - stencil.rest[k];
    }
    const auto m = moments(stencil.M, d);
    for (std::size_t k = 0; k < 3; ++k) {
      if (stencil.nodes[3 + k] < 0) continue;
      const auto slope = by_nodes(k, angles[k].slope);
      for (std::size_t a = 0; a < 6; ++a) {
        const PetscInt node = stencil.nodes[a];
        if (node < 0 || node >= num_owned_nodes_) continue;
        for (std::size_t i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(node) + i] += m[k] * slope[3 * a + i];
      }
    }
  }
}

// K = sum M_ij dtheta_i (x) dtheta_j + m_k d2theta_k; the first part has no negative eigenvalues.
void ShellBending::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                               Projection projection) const {
  for (const Stencil& stencil : seen(stage.near).stencils) {
    std::array<std::array<double, 18>, 3> slopes{};
    std::array<SecondOrder<9>, 3> angles;
    std::array<double, 3> d{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (stencil.nodes[3 + k] < 0) continue;
      angles[k] = differentiated_angle<2>(vectors(stencil, k, stage.near->coordinates, q));
      d[k] = angles[k].value - stencil.rest[k];
      slopes[k] = by_nodes(k, angles[k].slope);
    }
    std::array<double, 324> H{};
    for (std::size_t p = 0; p < 18; ++p) {
      const auto m = moments(stencil.M, {slopes[0][p], slopes[1][p], slopes[2][p]});
      for (std::size_t s = 0; s < 18; ++s) {
        H[18 * p + s] = m[0] * slopes[0][s] + (m[1] * slopes[1][s] + m[2] * slopes[2][s]);
      }
    }
    if (projection != Projection::positive_semidefinite) {
      const auto m = moments(stencil.M, d);
      for (std::size_t k = 0; k < 3; ++k) {
        if (stencil.nodes[3 + k] >= 0) add_bend(k, m[k], angles[k], H);
      }
    }
    for (std::size_t a = 0; a < 6; ++a) {
      if (stencil.nodes[a] < 0 || stencil.nodes[a] >= num_owned_nodes_) continue;
      for (std::size_t b = 0; b < 6; ++b) {
        if (stencil.nodes[b] < 0) continue;
        std::array<double, 9> block;
        for (std::size_t i = 0; i < 9; ++i) block[i] = H[18 * (3 * a + i / 3) + 3 * b + i % 3];
        K.add(stencil.nodes[a], stencil.nodes[b], block);
      }
    }
  }
}

}  // namespace pliant
