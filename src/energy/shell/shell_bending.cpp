#include "energy/shell/shell_bending.hpp"

#include "base/compensated_sum.hpp"
#include "energy/shell/hinge_sums.hpp"
#include "fem/facet_triangles.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pliant {
namespace {

using TriangleNodes = ShellTopology::Triangle;

/// f(local nodes, facet, number) of each triangle of each facet.
template <class F>
void for_each_triangle(const FacetList& facets, const F& f) {
  const auto triangles = triangles_of_facet(facets.nodes_per_facet);
  PetscInt number = 0;
  for (PetscInt facet = 0; facet < facets.size(); ++facet) {
    const auto nodes = facets.nodes_of(facet);
    for (const auto& [a, b, c] : triangles) f(std::array{nodes[a], nodes[b], nodes[c]}, facet, number++);
  }
}

TriangleNodes sorted(TriangleNodes nodes) {
  std::ranges::sort(nodes);
  return nodes;
}

/// 1 where the normal of a triangle points upwards, as z does; where it is horizontal as y does, or else as x: neither
/// side of it is outside.
double sign_of_upper_side(const NodeLayout& layout, const std::array<PetscInt, 3>& nodes) {
  constexpr double level = 1e-9;
  const Vector3<double> a = layout.position(nodes[0]), n = unit(cross(Vector3<double>(layout.position(nodes[1])) - a,
                                                                      Vector3<double>(layout.position(nodes[2])) - a));
  for (const std::size_t i : {2UL, 1UL, 0UL}) {
    if (std::abs(n[i]) > level) return n[i] > 0.0 ? 1.0 : -1.0;
  }
  return 1.0;
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
    for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt facet, PetscInt /*number*/) {
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
  for_each_triangle(facets, [&](const std::array<PetscInt, 3>& nodes, PetscInt facet, PetscInt of_facets) {
    const auto is_owned = [&](PetscInt node) { return node < layout.num_owned_nodes; };
    TriangleNodes global{};
    for (std::size_t k = 0; k < 3; ++k) global[k] = layout.global_node(nodes[k]);
    const auto place = std::ranges::lower_bound(topology_.triangles(), sorted(global), {}, sorted);
    const std::int64_t number = place - topology_.triangles().begin();
    std::array<PetscInt, 3> oriented{};
    for (std::size_t k = 0; k < 3; ++k) oriented[k] = nodes[std::ranges::find(global, (*place)[k]) - global.begin()];
    const bool is_rotation = oriented[(std::ranges::find(oriented, nodes[0]) - oriented.begin() + 1) % 3] == nodes[1];
    const bool is_outer = facets.is_outer[static_cast<std::size_t>(facet)] != 0;
    faces_[number] = {of_facets, !is_outer ? sign_of_upper_side(layout, oriented) : is_rotation ? 1.0 : -1.0};
    if (std::ranges::none_of(nodes, is_owned)) return;
    patches_.nodes.insert(patches_.nodes.end(), oriented.begin(), oriented.end());
    patches_.keys.push_back(number);
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
std::vector<double> changes(const Stencils& seen, std::span<const double> q) {
  std::vector<double> result;
  result.reserve(seen.hinges.size());
  for (const BendingHinge& hinge : seen.hinges) result.push_back(change_of_angle(hinge.rest, hinge.vectors(q)));
  return result;
}

/// Their moment about the hinge i of a stencil [N m].
double moment(const BendingStencil& stencil, std::size_t i, std::span<const double> d) {
  double result = 0.0;
  for (std::size_t j = 0; j < stencil.num_hinges; ++j)
    result += stencil.M[BendingStencil::most_hinges * i + j] * d[stencil.hinges[j]];
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

}  // namespace

std::shared_ptr<const PairFeatures> ShellBending::features_of(const NearPatches& near) const {
  return make_bending_stencils(topology_, stiffness_, near);
}

double ShellBending::value(const LocalStage& stage, std::span<const double> q) const {
  const Stencils& here = Stencils::seen(stage.near);
  if (here.stencils.empty()) return 0.0;
  auto now = changes(here, q), both = changes(here, stage.reference());
  for (std::size_t h = 0; h < now.size(); ++h) {
    const double then = both[h];
    both[h] = now[h] + then;
    now[h] -= then;
  }
  return half_product(here, now, both);
}

double ShellBending::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  const Stencils& here = Stencils::seen(at.near);
  if (here.stencils.empty()) return 0.0;
  const auto d = changes(here, q);
  return half_product(here, d, d);
}

void ShellBending::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const Stencils& here = Stencils::seen(stage.near);
  if (here.stencils.empty()) return;
  add_moments(here, moments(here, changes(here, q)), slopes_of_angles(here, q), num_owned_nodes_, r);
}

// K = sum M_ij dtheta_i (x) dtheta_j + m_i d2theta_i; the first part has no negative eigenvalues.
void ShellBending::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                               Projection projection) const {
  const Stencils& here = Stencils::seen(stage.near);
  if (here.stencils.empty()) return;
  const auto slopes = slopes_of_angles(here, q);
  for (const BendingStencil& stencil : here.stencils) {
    add_products(stencil, stencil.M, slopes, slopes, num_owned_nodes_, K);
  }
  if (projection == Projection::positive_semidefinite) return;
  const auto m = moments(here, changes(here, q));
  for (std::size_t h = 0; h < here.hinges.size(); ++h) add_bend(here.hinges[h], m[h], q, num_owned_nodes_, K);
}

namespace {

using Matrix2 = std::array<double, 4>;  // by rows

Matrix2 product(const Matrix2& a, const Matrix2& b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
}

/// How a triangle is deformed in its plane: from axes along and across its first side at rest to such axes now.
struct PlaneDeformation {
  Vector3<double> e1, e2;  ///< the axes now
  Matrix2 F{}, R{};        ///< deformation gradient, and its rotation

  PlaneDeformation(const std::array<Vector3<double>, 3>& X, const std::array<Vector3<double>, 3>& x) {
    const auto axes = [](const std::array<Vector3<double>, 3>& at) {
      const Vector3<double> first = unit(at[1] - at[0]), normal = unit(cross(first, at[2] - at[0]));
      return std::array{first, cross(normal, first)};
    };
    const auto [E1, E2] = axes(X);
    const auto now = axes(x);
    e1 = now[0];
    e2 = now[1];
    const double stretch = norm(x[1] - x[0]) / norm(X[1] - X[0]), height = dot(X[2] - X[0], E2);
    F = {stretch, (dot(x[2] - x[0], e1) - stretch * dot(X[2] - X[0], E1)) / height, 0.0, dot(x[2] - x[0], e2) / height};
    const double length = std::hypot(F[0] + F[3], F[2] - F[1]), c = (F[0] + F[3]) / length, s = (F[2] - F[1]) / length;
    R = {c, -s, s, c};
  }
  double area_ratio() const { return F[0] * F[3]; }
  Matrix2 inverse() const { return {1.0 / F[0], -F[1] / area_ratio(), 0.0, 1.0 / F[3]}; }
  Matrix2 transposed() const { return {F[0], F[2], F[1], F[3]}; }

  /// xx yy zz xy yz xz of factor times the symmetric part of R S A, S symmetric (11, 22, 12) at rest.
  std::array<double, 6> in_space(double factor, const std::array<double, 3>& S, const Matrix2& A) const {
    const Matrix2 T = product(R, product({S[0], S[2], S[2], S[1]}, A));
    const auto entry = [&](std::size_t i, std::size_t j) {
      return factor *
             (T[0] * e1[i] * e1[j] + T[3] * e2[i] * e2[j] + 0.5 * (T[1] + T[2]) * (e1[i] * e2[j] + e2[i] * e1[j]));
    };
    return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(1, 2), entry(0, 2)};
  }
};

}  // namespace

// Normals turn by dn = k dx = k F dX, so that the angles per length at rest are k F, and moments m that work on these
// are J^-1 m F^T per length now.
void ShellBending::visit(const NearPatches& near, std::span<const double> q,
                         const std::function<void(const BentTriangle&)>& visitor) const {
  const Stencils& here = Stencils::seen(&near);
  if (here.stencils.empty()) return;
  const auto d = changes(here, q);
  for (const BendingStencil& stencil : here.stencils) {
    const auto face = faces_.find(near.patches.keys[stencil.patch]);
    if (face == faces_.end()) continue;  // a triangle of another rank
    std::array<double, 3> change{}, whole{};
    for (std::size_t h = 0; h < stencil.num_hinges; ++h) {
      const auto& [e, u, v] = here.hinges[stencil.hinges[h]].rest;
      const double now = hinge_angle(e, u, v) + d[stencil.hinges[h]];
      for (std::size_t i = 0; i < 3; ++i) {
        change[i] += stencil.curvature[h][i] * d[stencil.hinges[h]];
        whole[i] += stencil.curvature[h][i] * now;
      }
    }
    const auto nodes = near.patches.nodes_of(stencil.patch);
    std::array<Vector3<double>, 3> X, x;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = 3 * static_cast<std::size_t>(nodes[k]);
      X[k] = {near.coordinates[i], near.coordinates[i + 1], near.coordinates[i + 2]};
      x[k] = near.position(nodes[k], q);
    }
    const PlaneDeformation plane(X, x);
    const double sign = -face->second.sign;  // angles are positive where triangles fold towards the normal
    const auto& [D, nu] = stencil.stiffness;
    const std::array<double, 3> moment{change[0] + nu * change[1], change[1] + nu * change[0],
                                       0.5 * (1.0 - nu) * change[2]};
    visitor({face->second.number, stencil.area, stencil.is_surrounded,
             plane.in_space(sign, {whole[0], whole[1], 0.5 * whole[2]}, plane.inverse()),
             plane.in_space(sign * D / plane.area_ratio(), moment, plane.transposed())});
  }
}

}  // namespace pliant
