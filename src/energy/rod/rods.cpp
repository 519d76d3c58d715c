#include "energy/rod/rods.hpp"

#include "base/compensated_sum.hpp"
#include "energy/rod/rod_pairs.hpp"
#include "fem/straight_cell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace pliant {
namespace {

using Place = std::array<double, 3>;
using Corners = std::array<Place, 4>;
/// Variables: three columns of a segment; t and d_1 of both segments of a vertex.
constexpr std::size_t per_segment = 9, per_vertex = 12;

/// 1/2 sum c (s^2 - s0^2) from the changes s - s0, all relative to what is at rest.
template <std::size_t M>
double change_of_energy(const std::array<double, M>& change, const std::array<double, M>& now,
                        const std::array<double, M>& then, const std::array<double, M>& stiffness) {
  double sum = 0.0;
  for (std::size_t k = 0; k < M; ++k) sum += 0.5 * stiffness[k] * change[k] * (now[k] + then[k]);
  return sum;
}

/// The columns of segments depend on their nodes by h_i = sum_a w_ai u_a.
using Weights = std::array<std::array<double, 3>, 4>;

std::array<StencilNode<3>, 4> stencil_of_segment(const std::array<PetscInt, 4>& nodes, const Weights& weights) {
  std::array<StencilNode<3>, 4> stencil;
  for (std::size_t a = 0; a < 4; ++a) stencil[a] = {nodes[a], weights[a]};
  return stencil;
}

/// The variables of a vertex: t and d_1 of its first segment, t and d_1 of its second.
std::array<StencilNode<4>, 8> stencil_of_vertex(const std::array<std::array<PetscInt, 4>, 2>& nodes,
                                                const std::array<const Weights*, 2>& weights) {
  std::array<StencilNode<4>, 8> stencil;
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t a = 0; a < 4; ++a) {
      StencilNode<4>& node = stencil[4 * side + a];
      node.node = nodes[side][a];
      for (std::size_t i = 0; i < 2; ++i) node.weights[2 * side + i] = (*weights[side])[a][i];
    }
  }
  return stencil;
}

/// t and d_1 of both segments of a vertex.
using Frames = std::array<Vector3<double>, 4>;

/// Not inlined, so that forces at rest, which are differences of these values, vanish to the last bit.
template <int order>
[[gnu::noinline]] std::array<Differentiated<per_vertex, order>, 3> strains_of_frames(const Frames& x) {
  using Number = Differentiated<per_vertex, order>;
  std::array<Vector3<Number>, 4> v;
  for (std::size_t i = 0; i < per_vertex; ++i) v[i / 3][i % 3] = Number::variable(x[i / 3][i % 3], i);
  return bending_and_twist(RodFrame<Number>{v[0], v[1]}, RodFrame<Number>{v[2], v[3]});
}

}  // namespace

Rods::Rods(const NodeLayout& layout, std::vector<std::ptrdiff_t> segment_of_cell, std::vector<RodSegment> segments,
           std::vector<RodVertex> vertices)
    : num_owned_nodes_(layout.num_owned_nodes),
      segments_(std::move(segments)),
      vertices_(std::move(vertices)),
      vertex_after_(segments_.size(), -1),
      segment_of_cell_(std::move(segment_of_cell)) {
  for (const RodSegment& segment : segments_) {
    const auto& X = segment.corners;
    Frame& frame = frames_.emplace_back();
    frame.axes[0] = unit(X[1] - X[0]);
    // The directors' points are opposite to the middle of a segment, or to the place of a section.
    const Vector3<double> across = X[2] - X[0];
    frame.axes[1] = unit(across - dot(across, frame.axes[0]) * frame.axes[0]);
    frame.axes[2] = cross(frame.axes[0], frame.axes[1]);
    const auto gradients = linear_gradients(X);
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t i = 0; i < 3; ++i) frame.weights[a][i] = dot(gradients[a], frame.axes[i]);
    }
  }
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    const std::size_t first = vertices_[v].first;
    vertex_after_[first] = static_cast<std::ptrdiff_t>(v);
    const RodFrame<double> a{frames_[first].axes[0], frames_[first].axes[1]},
        b{frames_[first + 1].axes[0], frames_[first + 1].axes[1]};
    rest_.push_back(bending_and_twist(a, b));
    rest_of_derivatives_.push_back(values_of(strains_of_frames<1>({a.t, a.d, b.t, b.d})));
  }
  std::vector<char> is_others(static_cast<std::size_t>(layout.num_local_nodes), 0);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (segment_of_cell_[static_cast<std::size_t>(c)] >= 0) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) is_others[static_cast<std::size_t>(n)] = 1;
  }
  patches_.nodes_per_patch = 4;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (segment_of_cell_[static_cast<std::size_t>(c)] < 0) continue;
    const auto nodes = layout.nodes_of_cell(c);
    Corners corners;
    for (std::size_t a = 0; a < 4; ++a) corners[a] = layout.position(nodes[a]);
    const auto number = static_cast<std::size_t>(segment_of_cell_[static_cast<std::size_t>(c)]);
    for (const Vector3<double>& X : segments_[number].corners) {
      const auto at = std::ranges::find(corners, X) - corners.begin();
      patches_.nodes.push_back(nodes[static_cast<std::size_t>(at)]);
    }
    patches_.keys.push_back(static_cast<std::int64_t>(number));
    patches_.tags.push_back(0);
    patches_.is_owned.push_back(patches_.nodes[patches_.nodes.size() - 4] < num_owned_nodes_ ? 1 : 0);
    const RodSegment& segment = segments_[number];
    if (segment.length > 0.0) add_middles(nodes, is_others, segment.axial / segment.length);
  }
  fixed_ = pairs_of_neighbours(layout, patches_, vertex_after_);
}

void Rods::add_middles(std::span<const PetscInt> nodes, std::span<const char> is_others, double stiffness) {
  if (nodes.size() == 4) return;
  constexpr std::array<std::array<std::size_t, 2>, 6> ends{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const PetscInt node = nodes[4 + e];
    if (is_others[static_cast<std::size_t>(node)] != 0) continue;
    middles_.push_back({node, nodes[ends[e][0]], nodes[ends[e][1]], stiffness});
  }
}

Vector3<double> Rods::offset(const Middle& middle, std::span<const double> q) {
  Vector3<double> d{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto of = [&](PetscInt node) { return q[3 * static_cast<std::size_t>(node) + i]; };
    d[i] = of(middle.node) - 0.5 * (of(middle.a) + of(middle.b));
  }
  return d;
}

std::shared_ptr<const PairFeatures> Rods::features_of(const NearPatches& near) const {
  auto seen = std::make_shared<Seen>();
  std::map<std::size_t, SegmentNodes> by_number;
  for (std::size_t p = 0; p < near.patches.size(); ++p) {
    SegmentNodes segment{static_cast<std::size_t>(near.patches.keys[p]), {}, near.patches.is_owned[p] != 0};
    std::ranges::copy(near.patches.nodes_of(p), segment.nodes.begin());
    by_number.emplace(segment.number, segment);
  }
  for (const auto& [number, segment] : by_number) {
    seen->segments.push_back(segment);
    const auto next = by_number.find(number + 1);
    if (next != by_number.end() && vertex_after_[number] >= 0) seen->vertices.push_back({segment, next->second});
  }
  return seen;
}

const Rods::Seen& Rods::seen(const NearPatches* near) {
  static const Seen none;
  return near != nullptr && near->features ? static_cast<const Seen&>(*near->features) : none;
}

TermDeclaration Rods::declaration() const {
  TermDeclaration declaration;
  declaration.rotates_with_body = false;
  return declaration;
}

std::array<Vector3<double>, 3> Rods::change_of_columns(const SegmentNodes& of, std::span<const double> q) const {
  std::array<Vector3<double>, 3> h{};
  const auto& weights = frames_[of.number].weights;
  for (std::size_t a = 0; a < 4; ++a) {
    const auto first = 3 * static_cast<std::size_t>(of.nodes[a]);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t c = 0; c < 3; ++c) h[i][c] += weights[a][i] * q[first + c];
    }
  }
  return h;
}

std::array<double, 6> Rods::strains_of(const SegmentNodes& of, std::span<const double> q) const {
  return stretch_and_distortion(frames_[of.number].axes, change_of_columns(of, q));
}

std::array<double, 6> Rods::stiffness_of(const SegmentNodes& of) const {
  const RodSegment& segment = segments_[of.number];
  std::array<double, 6> stiffness;
  stiffness.fill(segment.length * segment.distortion);
  stiffness[0] = segment.length * segment.axial;
  stiffness[3] *= 0.5;  // of d1 . d2: so that the choice of the directors in a round section makes no difference
  return stiffness;
}

std::array<double, 3> Rods::strains_of(const std::array<SegmentNodes, 2>& of, std::span<const double> q) const {
  std::array<RodFrame<double>, 2> frames;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto h = change_of_columns(of[side], q);
    const auto& axes = frames_[of[side].number].axes;
    frames[side] = {axes[0] + h[0], axes[1] + h[1]};
  }
  return bending_and_twist(frames[0], frames[1]);
}

std::array<double, 3> Rods::stiffness_of(std::size_t vertex) const {
  const RodVertex& of = vertices_[vertex];
  return {of.bending[0] / of.length, of.bending[1] / of.length, of.torsion / of.length};
}

double Rods::value(const LocalStage& stage, std::span<const double> q) const {
  CompensatedSum<double> sum;
  const Seen& here = seen(stage.near);
  const std::span<const double> from = stage.reference();
  for (const SegmentNodes& segment : here.segments) {
    if (!segment.is_counted) continue;
    const auto now = change_of_columns(segment, q), then = change_of_columns(segment, from);
    std::array<Vector3<double>, 3> change;
    const auto& weights = frames_[segment.number].weights;
    for (std::size_t i = 0; i < 3; ++i) {
      change[i] = {};
      for (std::size_t a = 0; a < 4; ++a) {
        const auto first = 3 * static_cast<std::size_t>(segment.nodes[a]);
        for (std::size_t c = 0; c < 3; ++c) change[i][c] += weights[a][i] * (q[first + c] - from[first + c]);
      }
    }
    const auto& axes = frames_[segment.number].axes;
    sum.add(change_of_energy(change_of_strains(axes, now, then, change), stretch_and_distortion(axes, now),
                             stretch_and_distortion(axes, then), stiffness_of(segment)));
  }
  for (const auto& vertex : here.vertices) {
    if (!vertex[0].is_counted) continue;
    const std::size_t number = number_of(vertex);
    auto now = strains_of(vertex, q), then = strains_of(vertex, from);
    std::array<double, 3> change{};
    for (std::size_t k = 0; k < 3; ++k) {
      change[k] = now[k] - then[k];
      now[k] -= rest_[number][k];
      then[k] -= rest_[number][k];
    }
    sum.add(change_of_energy(change, now, then, stiffness_of(number)));
  }
  for (const Middle& middle : middles_) {
    if (middle.node >= num_owned_nodes_) continue;
    const Vector3<double> now = offset(middle, q), then = offset(middle, from);
    sum.add(0.5 * middle.stiffness * dot(now - then, now + then));
  }
  return std::isfinite(sum.total()) ? sum.total() : std::numeric_limits<double>::infinity();
}

double Rods::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  CompensatedSum<double> sum;
  const Seen& here = seen(at.near);
  for (const SegmentNodes& segment : here.segments) {
    if (!segment.is_counted) continue;
    const auto s = strains_of(segment, q);
    sum.add(change_of_energy(s, s, {}, stiffness_of(segment)));
  }
  for (const auto& vertex : here.vertices) {
    if (!vertex[0].is_counted) continue;
    const std::size_t number = number_of(vertex);
    auto s = strains_of(vertex, q);
    for (std::size_t k = 0; k < 3; ++k) s[k] -= rest_[number][k];
    sum.add(change_of_energy(s, s, {}, stiffness_of(number)));
  }
  for (const Middle& middle : middles_) {
    const Vector3<double> d = offset(middle, q);
    if (middle.node < num_owned_nodes_) sum.add(0.5 * middle.stiffness * dot(d, d));
  }
  return sum.total();
}

template <int order>
Rods::Stencil<3, 4, 6, order> Rods::stencil(const SegmentNodes& segment, std::span<const double> q,
                                            std::span<const double> from) const {
  const Frame& frame = frames_[segment.number];
  const auto h = change_of_columns(segment, q);
  Stencil<3, 4, 6, order> result{stencil_of_segment(segment.nodes, frame.weights),
                                 {},
                                 differentiated_stretch_and_distortion<order>(frame.axes, h),
                                 stiffness_of(segment)};
  if (from.empty()) return result;
  const auto before = change_of_columns(segment, from);
  for (std::size_t i = 0; i < per_segment; ++i) result.change[i] = h[i / 3][i % 3] - before[i / 3][i % 3];
  return result;
}

template <int order>
Rods::Stencil<4, 8, 3, order> Rods::stencil(const std::array<SegmentNodes, 2>& vertex, std::span<const double> q,
                                            std::span<const double> from) const {
  const Frame &a = frames_[vertex[0].number], &b = frames_[vertex[1].number];
  const auto frames_at = [&](std::span<const double> u) {
    const auto h = change_of_columns(vertex[0], u), k = change_of_columns(vertex[1], u);
    return Frames{a.axes[0] + h[0], a.axes[1] + h[1], b.axes[0] + k[0], b.axes[1] + k[1]};
  };
  const Frames x = frames_at(q);
  Stencil<4, 8, 3, order> result{stencil_of_vertex({vertex[0].nodes, vertex[1].nodes}, {&a.weights, &b.weights}),
                                 {},
                                 strains_of_frames<order>(x),
                                 stiffness_of(number_of(vertex))};
  if (from.empty()) return result;
  const Frames before = frames_at(from);
  for (std::size_t i = 0; i < per_vertex; ++i) result.change[i] = x[i / 3][i % 3] - before[i / 3][i % 3];
  return result;
}

// RodViscosity has them too.
template Rods::Stencil<3, 4, 6, 1> Rods::stencil<1>(const SegmentNodes&, std::span<const double>,
                                                    std::span<const double>) const;
template Rods::Stencil<3, 4, 6, 2> Rods::stencil<2>(const SegmentNodes&, std::span<const double>,
                                                    std::span<const double>) const;
template Rods::Stencil<4, 8, 3, 1> Rods::stencil<1>(const std::array<SegmentNodes, 2>&, std::span<const double>,
                                                    std::span<const double>) const;
template Rods::Stencil<4, 8, 3, 2> Rods::stencil<2>(const std::array<SegmentNodes, 2>&, std::span<const double>,
                                                    std::span<const double>) const;

void Rods::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const Seen& here = seen(stage.near);
  for (const SegmentNodes& segment : here.segments) {
    const auto at = stencil<1>(segment, q, {});
    scatter_gradient(at.nodes, gradient_of(at.strains, {}, at.stiffness), num_owned_nodes_, r);
  }
  for (const auto& vertex : here.vertices) {
    const auto at = stencil<1>(vertex, q, {});
    scatter_gradient(at.nodes, gradient_of(at.strains, rest_of_derivatives_[number_of(vertex)], at.stiffness),
                     num_owned_nodes_, r);
  }
  for (const Middle& middle : middles_) {
    const std::array<StencilNode<1>, 3> stencil{{{middle.node, {1.0}}, {middle.a, {-0.5}}, {middle.b, {-0.5}}}};
    const Vector3<double> force = middle.stiffness * offset(middle, q);
    scatter_gradient(stencil, force, num_owned_nodes_, r);
  }
}

// Straight steps of slender rods stretch them much more than the solution does. Forces extrapolated along the last step
// keep that out of the Hessian (Magisano, Leonetti & Garcea 2017).
template <class Part, std::size_t M>
void Rods::add_hessian_of(const Part& part, const std::array<double, M>& rest, std::span<const double> q,
                          std::span<const double> previous, const BlockWriter& K, Projection projection) const {
  const auto at = stencil<2>(part, q, previous);
  const auto of_forces =
      previous.empty() ? values_of(at.strains) : extrapolated(stencil<1>(part, previous, {}).strains, at.change);
  auto hessian = hessian_of(at.strains, rest, at.stiffness, of_forces);
  if (projection == Projection::positive_semidefinite) {
    make_positive_semidefinite<std::tuple_size_v<decltype(at.change)>>(hessian);
  }
  scatter_hessian(at.nodes, hessian, num_owned_nodes_, K);
}

void Rods::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                       Projection projection) const {
  const Seen& here = seen(stage.near);
  for (const SegmentNodes& segment : here.segments) {
    add_hessian_of(segment, std::array<double, 6>{}, q, stage.previous, K, projection);
  }
  for (const auto& vertex : here.vertices) {
    add_hessian_of(vertex, rest_of_derivatives_[number_of(vertex)], q, stage.previous, K, projection);
  }
  for (const Middle& middle : middles_) {
    const std::array<StencilNode<1>, 3> stencil{{{middle.node, {1.0}}, {middle.a, {-0.5}}, {middle.b, {-0.5}}}};
    const double k = middle.stiffness;
    scatter_hessian(stencil, std::array{k, 0.0, 0.0, 0.0, k, 0.0, 0.0, 0.0, k}, num_owned_nodes_, K);
  }
}

// The axis has the mass, uniform over its length or in halves at its ends, and the frame the second moments.
void Rods::add_masses(const BlockPattern& pattern, MassMatrix& mass) const {
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const auto number = static_cast<std::size_t>(patches_.keys[p]);
    const RodSegment& segment = segments_[number];
    const auto nodes = patches_.nodes_of(p);
    const auto& weights = frames_[number].weights;
    constexpr std::array at_centre{0.5, 0.5, 0.0, 0.0};
    for (std::size_t a = 0; a < 4; ++a) {
      if (nodes[a] >= num_owned_nodes_) continue;
      for (std::size_t b = 0; b < 4; ++b) {
        double shared = segment.mass * at_centre[a] * at_centre[b];
        for (std::size_t i = 0; i < 3; ++i) shared += segment.second_moments[i] * weights[a][i] * weights[b][i];
        mass.add(pattern.block(nodes[a], nodes[b]), shared);
      }
    }
  }
}

std::vector<MassAtNode> Rods::masses(std::span<const char> of_segments) const {
  std::vector<MassAtNode> result;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const auto number = static_cast<std::size_t>(patches_.keys[p]);
    const RodSegment& segment = segments_[number];
    if (of_segments[number] == 0 || segment.mass == 0.0) continue;
    const Vector3<double> middle = 0.5 * (segment.corners[0] + segment.corners[1]);
    for (std::size_t a = 0; a < 2; ++a) {
      const PetscInt node = patches_.nodes_of(p)[a];
      if (node < num_owned_nodes_) result.push_back({node, 0.5 * segment.mass, middle});
    }
  }
  return result;
}

std::vector<Rods::SegmentNodes> Rods::segments_here() const {
  std::vector<SegmentNodes> result;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    SegmentNodes& segment = result.emplace_back();
    segment.number = static_cast<std::size_t>(patches_.keys[p]);
    segment.is_counted = patches_.is_owned[p] != 0;
    std::ranges::copy(patches_.nodes_of(p), segment.nodes.begin());
  }
  std::ranges::sort(result, {}, &SegmentNodes::number);
  return result;
}

std::vector<std::array<double, 3>> Rods::moments(const NearPatches& near, std::span<const double> q) const {
  std::vector<std::array<double, 3>> result(vertices_.size(), std::array<double, 3>{});
  for (const auto& vertex : seen(&near).vertices) {
    if (!vertex[0].is_counted) continue;
    const std::size_t number = number_of(vertex);
    const auto strains = strains_of(vertex, q), stiffness = stiffness_of(number);
    for (std::size_t k = 0; k < 3; ++k) result[number][k] = stiffness[k] * (strains[k] - rest_[number][k]);
  }
  return result;
}

double Rods::tension(const SegmentNodes& of, std::span<const double> u) const {
  return segments_[of.number].axial * strains_of(of, u)[0];
}

}  // namespace pliant
