#include "energy/shell/shell_bending.hpp"

#include "base/compensated_sum.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

using TriangleNodes = ShellTopology::Triangle;

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

TriangleNodes sorted(TriangleNodes nodes) {
  std::ranges::sort(nodes);
  return nodes;
}

/// Those of all ranks, in halves where they have a node in the middle.
std::vector<ClampedEdge> clamped_edges(const NodeLayout& layout, std::span<const ClampedEdges> clamped) {
  std::vector<ClampedEdge> here;
  for (std::size_t k = 0; k < clamped.size(); ++k) {
    const ClampedEdges& of = clamped[k];
    const auto width = static_cast<std::size_t>(of.edges.nodes_per_edge);
    for (std::size_t e = 0; e < of.edges.is_owned.size(); ++e) {
      if (of.edges.is_owned[e] == 0) continue;
      const auto add = [&](PetscInt a, PetscInt b) {
        const std::int64_t one = layout.global_node(a), other = layout.global_node(b);
        here.push_back({{std::min(one, other), std::max(one, other)},
                        of.normal.value_or(Vector3<double>{}),
                        of.normal ? char{1} : char{0},
                        static_cast<std::int32_t>(k)});
      };
      const PetscInt* nodes = &of.edges.nodes[width * e];
      if (width == 2) {
        add(nodes[0], nodes[1]);
      } else {
        add(nodes[0], nodes[2]);
        add(nodes[2], nodes[1]);
      }
    }
  }
  return gathered(layout.comm, here);
}

struct GivenTriangle {
  TriangleNodes nodes{};
  BendingStiffness stiffness;
};

/// Those of all ranks, by their sorted nodes.
std::vector<GivenTriangle> all_triangles(
    const NodeLayout& layout, const FacetList& facets,
    const std::function<BendingStiffness(const std::array<double, 3>&)>& stiffness) {
  std::vector<GivenTriangle> here;
  on_every_rank(layout.comm, [&] {
    for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt facet) {
      if (facets.is_owned[facet] == 0) return;
      GivenTriangle& triangle = here.emplace_back();
      Vector3<double> middle{};
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.nodes[k] = layout.global_node(nodes[k]);
        middle = middle + (1.0 / 3.0) * Vector3<double>(layout.position(nodes[k]));
      }
      triangle.stiffness = stiffness(middle);
    });
  });
  std::vector<GivenTriangle> result = gathered(layout.comm, here);
  std::ranges::sort(result, {}, [](const GivenTriangle& triangle) { return sorted(triangle.nodes); });
  return result;
}

}  // namespace

ShellBending::ShellBending(const NodeLayout& layout, const FacetList& facets,
                           const std::function<BendingStiffness(const std::array<double, 3>&)>& stiffness,
                           std::span<const ClampedEdges> clamped)
    : num_owned_nodes_(layout.num_owned_nodes), first_owned_node_(layout.first_global_node) {
  std::vector<TriangleNodes> triangles;
  for (const GivenTriangle& given : all_triangles(layout, facets, stiffness)) {
    triangles.push_back(given.nodes);
    stiffness_.push_back(given.stiffness);
  }
  topology_ = ShellTopology(std::move(triangles), clamped_edges(layout, clamped));

  list_patches(layout, facets);
  fix_pairs();
}

// All ranks know the corners in the same order.
void ShellBending::list_patches(const NodeLayout& layout, const FacetList& facets) {
  patches_.nodes_per_patch = 3;
  for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt /*facet*/) {
    const auto is_owned = [&](PetscInt node) { return node < layout.num_owned_nodes; };
    if (std::ranges::none_of(nodes, is_owned)) return;
    TriangleNodes global{};
    for (std::size_t k = 0; k < 3; ++k) global[k] = layout.global_node(nodes[k]);
    const auto place = std::ranges::lower_bound(topology_.triangles(), sorted(global), {}, sorted);
    for (const std::int64_t node : *place) {
      patches_.nodes.push_back(nodes[static_cast<std::size_t>(std::ranges::find(global, node) - global.begin())]);
    }
    patches_.keys.push_back(place - topology_.triangles().begin());
    patches_.tags.push_back(0);
    const auto first = std::ranges::min_element(global) - global.begin();
    patches_.is_owned.push_back(is_owned(nodes[static_cast<std::size_t>(first)]) ? 1 : 0);
  });
}

// Whoever owns a node of a patch needs all of its triangles.
void ShellBending::fix_pairs() {
  const std::size_t num_triangles = topology_.triangles().size();
  std::vector<char> is_here(num_triangles, 0), is_needed(num_triangles, 0);
  std::vector<std::size_t> number(num_triangles, 0);
  for (std::size_t p = 0; p < patches_.keys.size(); ++p) {
    is_here[static_cast<std::size_t>(patches_.keys[p])] = 1;
    number[static_cast<std::size_t>(patches_.keys[p])] = p;
  }
  std::vector<std::pair<std::int64_t, std::int64_t>> pairs;
  const auto has_owned_node = [&](std::int64_t triangle) {
    return std::ranges::any_of(topology_.triangles()[static_cast<std::size_t>(triangle)], [&](std::int64_t node) {
      return node >= first_owned_node_ && node < first_owned_node_ + num_owned_nodes_;
    });
  };
  for (std::size_t t = 0; t < num_triangles; ++t) {
    const auto patch = topology_.patch(t);
    if (std::ranges::none_of(patch, has_owned_node)) continue;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      is_needed[static_cast<std::size_t>(patch[i])] = 1;
      for (std::size_t j = 0; j < i; ++j) pairs.emplace_back(patch[j], patch[i]);
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  for (std::size_t t = 0; t < num_triangles; ++t) {
    if (is_needed[t] == 0 || is_here[t] != 0) continue;
    number[t] = patches_.size() + fixed_.keys.size();
    fixed_.keys.push_back(static_cast<std::int64_t>(t));
    fixed_.tags.push_back(0);
    for (const std::int64_t node : topology_.triangles()[t]) fixed_.global_nodes.push_back(static_cast<PetscInt>(node));
  }
  for (const auto& [first, second] : pairs) {
    fixed_.pairs.push_back({number[static_cast<std::size_t>(first)], number[static_cast<std::size_t>(second)]});
  }
}

namespace {

using Stencils = BendingStencils;
constexpr std::size_t most_hinges = BendingStencil::most_hinges, most_nodes = BendingStencil::most_nodes;

const Stencils& seen(const NearPatches* near) {
  static const Stencils none;
  return near != nullptr && near->features ? static_cast<const Stencils&>(*near->features) : none;
}

/// theta - theta^0 from the changes of e, u and v since the start, in a form without cancellation: stiff plates live in
/// the last digits of angles. With t = v.n, w = v x e, s = |e| t and c = n.w, the angle is atan2(s, c), and the change
/// that of (s0, c0) to (s, c) = (s0 + ds, c0 + dc): atan2(ds c0 - dc s0, c c0 + s s0).
double change_of_angle(const HingeVectors& before, const HingeVectors& change) {
  const auto& [e0, u0, v0] = before;
  const auto& [de, du, dv] = change;
  const Vector3<double> e = e0 + de, u = u0 + du, v = v0 + dv;
  const Vector3<double> n0 = cross(e0, u0), n = cross(e, u), dn = cross(de, u) + cross(e0, du);
  const Vector3<double> w0 = cross(v0, e0), w = cross(v, e), dw = cross(dv, e) + cross(v0, de);
  const double length0 = norm(e0), length = norm(e), d_length = dot(de, e0 + e) / (length0 + length);
  const double t = dot(v, n), dt = dot(dv, n) + dot(v0, dn);
  const double s0 = length0 * dot(v0, n0), ds = length0 * dt + t * d_length;
  const double c0 = dot(n0, w0), dc = dot(dn, w) + dot(n0, dw);
  return std::atan2(ds * c0 - dc * s0, (c0 + dc) * c0 + (s0 + ds) * s0);
}

/// theta - theta^0 of all hinges.
std::vector<double> changes(const Stencils& seen, std::span<const double> X, std::span<const double> q) {
  const std::vector<double> zero(X.size(), 0.0);
  std::vector<double> result;
  result.reserve(seen.hinges.size());
  for (const BendingHinge& hinge : seen.hinges) {
    result.push_back(change_of_angle(hinge.vectors(X, zero), hinge.vectors(zero, q)));
  }
  return result;
}

/// Their moment about the hinge i of a stencil [N m].
double moment(const BendingStencil& stencil, std::size_t i, std::span<const double> d) {
  double result = 0.0;
  for (std::size_t j = 0; j < stencil.num_hinges; ++j) result += stencil.M[most_hinges * i + j] * d[stencil.hinges[j]];
  return result;
}

/// The moment of all stencils about each hinge [N m].
std::vector<double> moments(const Stencils& seen, std::span<const double> d) {
  std::vector<double> result(seen.hinges.size(), 0.0);
  for (const BendingStencil& stencil : seen.stencils) {
    for (std::size_t i = 0; i < stencil.num_hinges; ++i) result[stencil.hinges[i]] += moment(stencil, i, d);
  }
  return result;
}

/// The sum of d.M.m / 2 over the triangles that this rank counts.
double half_product(const Stencils& seen, std::span<const double> d, std::span<const double> m) {
  CompensatedSum<double> total;
  for (const BendingStencil& stencil : seen.stencils) {
    if (!stencil.is_counted) continue;
    for (std::size_t i = 0; i < stencil.num_hinges; ++i) total.add(0.5 * d[stencil.hinges[i]] * moment(stencil, i, m));
  }
  return total.total();
}

/// The slopes of the angles by the nodes a, b, c, o.
struct Slopes {
  std::vector<std::array<double, 12>> by_nodes;

  Slopes(const Stencils& seen, std::span<const double> X, std::span<const double> q) {
    for (const BendingHinge& hinge : seen.hinges) {
      const auto angle = differentiated_angle<1>(hinge.vectors(X, q));
      const HingeMap map = hinge.map();
      auto& slopes = by_nodes.emplace_back();
      for (std::size_t row = 0; row < 9; ++row) {
        for (std::size_t k = 0; k < 12; ++k) slopes[k] += map[12 * row + k] * angle.slope[row];
      }
    }
  }
};

}  // namespace

std::shared_ptr<const PairFeatures> ShellBending::features_of(const NearPatches& near) const {
  return make_bending_stencils(topology_, stiffness_, near);
}

double ShellBending::value(const LocalStage& stage, std::span<const double> q) const {
  const Stencils& here = seen(stage.near);
  if (here.stencils.empty()) return 0.0;
  auto now = changes(here, stage.near->coordinates, q),
       both = changes(here, stage.near->coordinates, stage.reference());
  for (std::size_t h = 0; h < now.size(); ++h) {
    const double then = both[h];
    both[h] = now[h] + then;
    now[h] -= then;
  }
  return half_product(here, now, both);
}

double ShellBending::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  const Stencils& here = seen(at.near);
  if (here.stencils.empty()) return 0.0;
  const auto d = changes(here, at.near->coordinates, q);
  return half_product(here, d, d);
}

void ShellBending::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const Stencils& here = seen(stage.near);
  if (here.stencils.empty()) return;
  const Slopes slopes(here, stage.near->coordinates, q);
  const auto m = moments(here, changes(here, stage.near->coordinates, q));
  for (std::size_t h = 0; h < here.hinges.size(); ++h) {
    for (std::size_t a = 0; a < 4; ++a) {
      const PetscInt node = here.hinges[h].nodes[a];
      if (node < 0 || node >= num_owned_nodes_) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        r[3 * static_cast<std::size_t>(node) + i] += m[h] * slopes.by_nodes[h][3 * a + i];
      }
    }
  }
}

// K = sum M_ij dtheta_i (x) dtheta_j + m_i d2theta_i; the first part has no negative eigenvalues.
void ShellBending::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                               Projection projection) const {
  const Stencils& here = seen(stage.near);
  if (here.stencils.empty()) return;
  const Slopes slopes(here, stage.near->coordinates, q);
  for (const BendingStencil& stencil : here.stencils) add_stencil(stencil, slopes.by_nodes, K);
  if (projection == Projection::positive_semidefinite) return;
  const auto m = moments(here, changes(here, stage.near->coordinates, q));
  for (std::size_t h = 0; h < here.hinges.size(); ++h) add_bend(here.hinges[h], m[h], *stage.near, q, K);
}

void ShellBending::add_stencil(const BendingStencil& stencil, std::span<const std::array<double, 12>> slopes,
                               const BlockWriter& K) const {
  constexpr std::size_t width = 3 * most_nodes;
  const std::size_t n = stencil.num_hinges;
  std::array<double, most_hinges * width> W{}, MW{};  // the slopes of the hinges by all nodes
  for (std::size_t h = 0; h < n; ++h) {
    for (std::size_t k = 0; k < 12; ++k) {
      const auto place = stencil.places[h][k / 3];
      if (place >= 0) W[width * h + 3 * static_cast<std::size_t>(place) + k % 3] += slopes[stencil.hinges[h]][k];
    }
  }
  for (std::size_t h = 0; h < n; ++h) {
    for (std::size_t g = 0; g < n; ++g) {
      for (std::size_t k = 0; k < width; ++k) MW[width * h + k] += stencil.M[most_hinges * h + g] * W[width * g + k];
    }
  }
  for (std::size_t a = 0; a < stencil.num_nodes; ++a) {
    if (stencil.nodes[a] >= num_owned_nodes_) continue;
    for (std::size_t b = 0; b < stencil.num_nodes; ++b) {
      std::array<double, 9> block{};
      for (std::size_t h = 0; h < n; ++h) {
        for (std::size_t i = 0; i < 9; ++i) block[i] += W[width * h + 3 * a + i / 3] * MW[width * h + 3 * b + i % 3];
      }
      K.add(stencil.nodes[a], stencil.nodes[b], block);
    }
  }
}

void ShellBending::add_bend(const BendingHinge& hinge, double moment, const NearPatches& near,
                            std::span<const double> q, const BlockWriter& K) const {
  if (moment == 0.0) return;
  if (std::ranges::none_of(hinge.nodes, [&](PetscInt n) { return n >= 0 && n < num_owned_nodes_; })) return;
  const auto angle = differentiated_angle<2>(hinge.vectors(near.coordinates, q));
  const HingeMap map = hinge.map();
  std::array<double, 108> BJ{};  // 9 x 12
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t s = 0; s < 9; ++s) {
      const double entry = moment * angle.bend_of(p, s);
      for (std::size_t k = 0; k < 12; ++k) BJ[12 * p + k] += entry * map[12 * s + k];
    }
  }
  for (std::size_t a = 0; a < 4; ++a) {
    if (hinge.nodes[a] < 0 || hinge.nodes[a] >= num_owned_nodes_) continue;
    for (std::size_t b = 0; b < 4; ++b) {
      if (hinge.nodes[b] < 0) continue;
      std::array<double, 9> block{};
      for (std::size_t p = 0; p < 9; ++p) {
        for (std::size_t i = 0; i < 9; ++i) block[i] += map[12 * p + 3 * a + i / 3] * BJ[12 * p + 3 * b + i % 3];
      }
      K.add(hinge.nodes[a], hinge.nodes[b], block);
    }
  }
}

}  // namespace pliant
