#include "model/start_adjustment.hpp"

#include "collision/candidates.hpp"
#include "collision/overlaps.hpp"
#include "energy/contact/separation.hpp"
#include "fem/deformed_cell.hpp"
#include "fem/element.hpp"
#include "model/body_contact_laws.hpp"
#include "model/contact_summary.hpp"
#include "model/initial_displacement.hpp"
#include "model/rigid_bodies.hpp"
#include "model/tied_surfaces.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The distance at which the barrier begins, relative to a facet, unless the input says it; surfaces start twice as far
/// apart: a thousandth of a facet is below what the mesh resolves, and Newton's method takes no longer for it.
constexpr double start_width_per_facet = 1.0 / 2000.0;
/// Steps by which nodes inside the bodies follow, each to the mean of its neighbours.
constexpr int smoothing_steps = 10;
/// The least part of its volume that an element keeps, anywhere in it.
constexpr double least_volume = 0.2;
/// Because the displacement at the start depends on where the nodes are.
constexpr int most_passes = 3;

/// Two bodies that do not start apart.
struct Adjustment {
  std::size_t body = 0, other = 0;
  double depth = 0.0;        ///< 0: they only touch, or are too near [m]
  bool is_too_near = false;  ///< nearer than the threshold
};

/// The surfaces of one entry of `contact.pairs`.
class EntryAdjuster {
 public:
  EntryAdjuster(const ContactConfig& config, const TouchingSurfaces& touching, std::size_t num_bodies,
                const NodeLayout& layout)
      : touching_(touching),
        num_bodies_(num_bodies),
        is_thin_(num_bodies, 0),
        through_nodes_(make(layout, FacetVertices::nodes)) {
    if (touching.facets.nodes_per_facet == 6) with_means_.emplace(make(layout, FacetVertices::mean));
    const auto* pair = touching.config;
    width_ = pair != nullptr && pair->width ? pair->width : config.pressure.width;
    threshold_ = pair != nullptr && pair->thickness ? *pair->thickness : config.pressure.threshold;
    for (const auto& triangle : through_nodes_.surface().triangles()) {
      if (triangle.is_thin()) is_thin_[triangle.body] = 1;
    }
  }

  /// Moves the nodes' positions; returns what was done. Rank-local, and the same on every rank.
  std::vector<Adjustment> operator()(std::span<Vector3<double>> x) const {
    const CollisionSurface& surface = through_nodes_.surface();
    const double triangles_per_facet = with_means_ ? 4.0 : 1.0;
    const std::vector<double> sizes = facet_sizes(surface, num_bodies_, triangles_per_facet);
    GapGoals goals{static_cast<int>(num_bodies_), std::vector<GapGoal>(num_bodies_ * num_bodies_)};
    std::vector<Adjustment> adjustments;
    for (const Adjustment& overlap : overlaps(x)) {
      const std::size_t body = overlap.body, other = overlap.other;
      const double size = std::min(sizes[body], sizes[other]), width = width_.value_or(start_width_per_facet * size);
      if (overlap.depth > size) continue;
      const GapGoal goal{threshold_ + 2.0 * width, threshold_ + width, size, overlap.depth};
      goals.of_bodies[body * num_bodies_ + other] = goals.of_bodies[other * num_bodies_ + body] = goal;
      adjustments.push_back(overlap);
    }
    if (adjustments.empty()) return adjustments;
    std::vector<const BodySurfaces*> surfaces{&through_nodes_};
    if (with_means_) surfaces.push_back(&*with_means_);
    move_apart(surfaces, touching_.sets, goals, x);
    return adjustments;
  }

  const BodySurfaces& surfaces() const { return through_nodes_; }

 private:
  BodySurfaces make(const NodeLayout& layout, FacetVertices vertices) const {
    return {layout, touching_.facets, touching_.sides, vertices};
  }

  /// Bodies that overlap, touch, or are nearer than the threshold.
  std::vector<Adjustment> overlaps(std::span<const Vector3<double>> nodes) const {
    std::vector<Adjustment> found;
    const auto include = [&](std::size_t body, std::size_t other, double depth, bool is_too_near) {
      if (body == other || is_thin_[body] != 0 || is_thin_[other] != 0) return;
      const auto same = std::ranges::find_if(
          found, [&](const Adjustment& known) { return known.body == body && known.other == other; });
      if (same != found.end()) {
        same->depth = std::max(same->depth, depth);
      } else {
        found.push_back({body, other, depth, is_too_near});
      }
    };
    const CollisionSurface& surface = through_nodes_.surface();
    for (const SurfaceOverlap& overlap : find_overlaps(surface, nodes, touching_.sets)) {
      include(static_cast<std::size_t>(overlap.body), static_cast<std::size_t>(overlap.other), overlap.depth, false);
    }
    if (!(threshold_ > 0.0)) return found;
    const auto may_meet = bodies_that_may_meet(surface, touching_.sets, num_bodies_);
    const auto apart = least_distances(surface, nodes, static_cast<int>(num_bodies_), threshold_);
    for (std::size_t a = 0; a < num_bodies_; ++a) {
      for (std::size_t b = a + 1; b < num_bodies_; ++b) {
        const std::size_t place = a * num_bodies_ + b;
        if (may_meet[place] != 0 && apart[place] < threshold_) include(a, b, 0.0, true);
      }
    }
    return found;
  }

  const TouchingSurfaces& touching_;
  std::size_t num_bodies_;
  std::vector<char> is_thin_;  // of each body: it is a shell or a rod, which is not moved
  BodySurfaces through_nodes_;
  std::optional<BodySurfaces> with_means_;
  std::optional<double> width_;
  double threshold_ = 0.0;
};

/// The change of the mesh, known at first at nodes of surfaces.
class MeshMotion {
 public:
  /// Collective.
  MeshMotion(const NodeLayout& layout, const FacetList& boundary)
      : layout_(layout),
        shift_(make_vector(layout)),
        is_boundary_(static_cast<std::size_t>(layout.num_local_nodes), 0),
        is_set_(is_boundary_) {
    for (const PetscInt node : boundary.nodes) is_boundary_[node] = 1;
  }

  /// Moves the nodes of surfaces from `before` to `after`, which are the same on every rank. Not collective.
  void add(const BodySurfaces& surfaces, std::span<const Vector3<double>> before,
           std::span<const Vector3<double>> after) {
    const auto vertices = surfaces.surface().vertices();
    const GhostedView shift(shift_.get());
    for (PetscInt node = 0; node < layout_.num_local_nodes; ++node) {
      const VertexKey key{layout_.global_node(node)};
      const auto found = std::ranges::lower_bound(vertices, key, {}, &CollisionSurface::Vertex::key);
      if (found == vertices.end() || found->key != key) continue;
      const auto v = static_cast<std::size_t>(found - vertices.begin());
      if (after[v] == before[v]) continue;
      is_set_[node] = 1;
      for (std::size_t i = 0; i < 3; ++i) shift.span()[3 * node + i] += after[v][i] - before[v][i];
    }
  }

  /// Lets the other nodes follow: those of the boundary stay, but between two corners that move. Collective.
  void spread() {
    const auto num_owned = static_cast<std::size_t>(layout_.num_owned_nodes);
    std::vector<Vector3<double>> sum(num_owned);
    std::vector<double> number(num_owned);
    for (int step = 0; step < smoothing_steps; ++step) {
      std::ranges::fill(sum, Vector3<double>{});
      std::ranges::fill(number, 0.0);
      {
        const GhostedView shift(shift_.get());
        for_each_edge([&](PetscInt a, PetscInt b, PetscInt) {
          for (const auto& [to, from] : {std::pair(a, b), std::pair(b, a)}) {
            if (to >= layout_.num_owned_nodes) continue;
            sum[to] = sum[to] + at(shift.span(), from);
            number[to] += 1.0;
          }
        });
        for (PetscInt node = 0; node < layout_.num_owned_nodes; ++node) {
          if (number[node] == 0.0 || is_boundary_[node] != 0) continue;
          for (std::size_t i = 0; i < 3; ++i) shift.span()[3 * node + i] = sum[node][i] / number[node];
        }
      }
      update_ghosts(shift_.get());
    }
    if (layout_.order == 1) return;
    {
      const GhostedView shift(shift_.get());
      for_each_edge([&](PetscInt a, PetscInt b, PetscInt middle) {
        if (middle >= layout_.num_owned_nodes || is_set_[middle] != 0) return;
        const Vector3<double> mean = 0.5 * (at(shift.span(), a) + at(shift.span(), b));
        for (std::size_t i = 0; i < 3; ++i) shift.span()[3 * middle + i] = mean[i];
      });
    }
    update_ghosts(shift_.get());
  }

  /// Collective.
  void apply(NodeLayout& layout) const {
    const ConstGhostedView shift(shift_.get());
    for (std::size_t i = 0; i < layout.coordinates.size(); ++i) layout.coordinates[i] += shift.span()[i];
  }

 private:
  static Vector3<double> at(std::span<const double> values, PetscInt node) {
    return {values[3 * node], values[3 * node + 1], values[3 * node + 2]};
  }
  /// f(corner, corner, middle) of each edge of each local cell; the middle is meaningless for linear cells.
  template <class F>
  void for_each_edge(const F& f) const {
    for (PetscInt cell = 0; cell < layout_.num_local_cells; ++cell) {
      const auto nodes = layout_.nodes_of_cell(cell);
      for (std::size_t e = 0; e < 6; ++e) {
        f(nodes[tet_edges[e][0]], nodes[tet_edges[e][1]], layout_.order == 1 ? PetscInt{0} : nodes[4 + e]);
      }
    }
  }

  const NodeLayout& layout_;
  Handle<Vec> shift_;
  std::vector<char> is_boundary_, is_set_;
};

/// The change from one layout to another of the same mesh.
class MeshChange {
 public:
  MeshChange(const NodeLayout& before, const NodeLayout& after) : before_(before), u_(after.coordinates) {
    for (std::size_t i = 0; i < u_.size(); ++i) u_[i] -= before.coordinates[i];
  }

  /// The number of nodes that moved on the surfaces of a body, and the farthest way [m]. Collective.
  std::pair<double, double> motion(const TouchingSurfaces& touching, std::size_t body) const {
    std::set<PetscInt> moved;
    double farthest = 0.0;
    for (PetscInt facet = 0; facet < touching.facets.size(); ++facet) {
      if (static_cast<std::size_t>(touching.sides[facet].body) != body) continue;
      for (const PetscInt node : touching.facets.nodes_of(facet)) {
        const double way = norm(Vector3<double>{u_[3 * node], u_[3 * node + 1], u_[3 * node + 2]});
        if (node >= before_.num_owned_nodes || !(way > 0.0)) continue;
        moved.insert(node);
        farthest = std::max(farthest, way);
      }
    }
    return {sum(before_.comm, static_cast<double>(moved.size())), maximum(before_.comm, farthest)};
  }

  /// Throws InputError if an element has lost most of its volume. Collective.
  void require_volume(const Location& where) const {
    DeformedCell worst;
    for (PetscInt cell = 0; cell < before_.num_owned_cells; ++cell) {
      const DeformedCell here = deformed_cell(before_, cell, u_);
      if (here.volume_ratio < worst.volume_ratio) worst = here;
    }
    const auto all = gathered(before_.comm, std::array{worst});
    worst = *std::ranges::min_element(all, {}, &DeformedCell::volume_ratio);
    if (worst.volume_ratio >= least_volume) return;
    throw InputError(where,
                     fmt::format("bodies overlap so deeply in the mesh that 'start: resolve' would flatten an element "
                                 "near {}, or turn it inside out; move the bodies apart in the geometry",
                                 place_text(worst.X)));
  }

 private:
  const NodeLayout& before_;
  std::vector<double> u_;
};

}  // namespace

std::vector<Diagnostic> adjust_start(const ContactConfig& config, std::span<const TouchingSurfaces> touching,
                                     const std::vector<std::string>& body_names, const VectorExpression& displacement,
                                     const FacetList& boundary, const NodeLayout& as_meshed, NodeLayout& layout) {
  std::vector<std::vector<Adjustment>> adjustments(touching.size());
  bool is_changed = true;
  for (int round = 0; round < most_passes && is_changed; ++round) {
    is_changed = false;
    for (std::size_t entry = 0; entry < touching.size(); ++entry) {
      const EntryAdjuster adjust(config, touching[entry], body_names.size(), layout);
      const auto x = gathered_nodes(layout, adjust.surfaces(), initial_displacement(displacement, layout));
      std::vector<Vector3<double>> moved = x;
      const auto done = adjust(moved);
      if (done.empty()) continue;
      is_changed = true;
      if (round == 0) adjustments[entry] = done;
      MeshMotion motion(layout, boundary);
      motion.add(adjust.surfaces(), x, moved);
      motion.spread();
      motion.apply(layout);
    }
  }
  const MeshChange change(as_meshed, layout);
  change.require_volume(config.where);
  if (layout.order == 2) mark_bent_cells(layout);
  std::vector<Diagnostic> notes;
  for (std::size_t entry = 0; entry < touching.size(); ++entry) {
    for (const Adjustment& adjustment : adjustments[entry]) {
      const auto [number, way] = change.motion(touching[entry], adjustment.body);
      const auto [number_of_other, way_of_other] = change.motion(touching[entry], adjustment.other);
      notes.push_back(note(
          fmt::format("'{}' and '{}' {} in the mesh; 'start: resolve' moves {:.0f} nodes of their surfaces by up to "
                      "{:.3g} m",
                      body_names[adjustment.body], body_names[adjustment.other],
                      adjustment.depth > 0.0   ? fmt::format("overlap by up to {:.3g} m", adjustment.depth)
                      : adjustment.is_too_near ? std::string("are nearer than their 'thickness'")
                                               : std::string("touch"),
                      number + number_of_other, std::max(way, way_of_other))));
    }
  }
  return notes;
}

bool resolves_start(const Config& config) {
  return config.contact && config.contact->start == ContactStart::resolve;
}

std::vector<std::string> parts_that_meet(const Config& config) {
  std::vector<std::string> names = names_of_added_bodies(config).names;
  for (const auto& surfaces : tied_surfaces(config)) names.push_back(surfaces[1].name);
  for (const BodyConfig& body : config.bodies) {
    for (const Selection& surface : surfaces_held_by(body)) names.push_back(surface.name);
  }
  if (!config.contact) return names;
  const auto may_touch = [&](const ContactPairConfig* pair) {
    return resolves_start(config) || config.contact->law_of(pair) == NormalKind::penalty;
  };
  for (const ContactPairConfig& pair : config.contact->pairs.list) {
    if (!may_touch(&pair)) continue;
    names.push_back(pair.part.value);
    if (pair.with) names.push_back(pair.with->value);
  }
  if (config.contact->pairs.all && may_touch(nullptr)) {
    for (const BodyConfig& body : config.bodies) names.push_back(body.part.name);
  }
  return names;
}

}  // namespace pliant
