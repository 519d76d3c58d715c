/// The surfaces of bodies that may touch one another, and what is near one another on them.
#pragma once

#include "collision/contact_pairs.hpp"
#include "energy/contact/body_surfaces.hpp"
#include "energy/contact/surface_crossings.hpp"
#include "energy/contact/touch.hpp"
#include "energy/term.hpp"
#include "material/contact_law.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// The contact law of each two bodies (FacetSide::body): a symmetric matrix by rows.
struct BodyContactLaws {
  int num_bodies = 1;
  std::vector<NormalLaw> of_bodies;
  /// How far along the surface, for each two bodies, parts of what is thin count as neighbours, which do not feel each
  /// other [m] (SurfaceNeighbours); empty: nowhere.
  std::vector<double> neighbour_distances;

  const NormalLaw& of(int body, int other) const { return of_bodies[num_bodies * body + other]; }
  NormalResponse operator()(int body, int other, double distance) const { return of(body, other)(distance); }
  /// The greatest distance at which one of them acts [m].
  double reach() const {
    double reach = 0.0;
    for (const NormalLaw& law : of_bodies) reach = std::max(reach, law.reach());
    return reach;
  }
  /// Whether all bodies keep the same distance: then one reach is about right for all of them.
  bool keep_one_distance() const {
    return std::ranges::all_of(of_bodies,
                               [&](const NormalLaw& law) { return law.threshold == of_bodies[0].threshold; });
  }
  /// Whether they let surfaces pass into each other; all are of one kind.
  bool is_penalty() const { return of_bodies.front().kind == NormalKind::penalty; }
};

/// What a penalty between bodies needs in addition.
struct PenaltyParts {
  double depth = 0.0;            ///< to which it pushes what is in another body out again [m]
  std::vector<char> has_points;  ///< of each set, whether its points feel others; empty: all do
  std::vector<char> is_mirror;  ///< of each set, whether it is on a plane of symmetry, where nothing is pushed out, but
                                ///< the surface does not end either; empty: none is
  const bool* limits_steps = nullptr;  ///< whether max_step() stops at a depth, at the time of a call; nullptr: never
};

/// The gap of surfaces that may touch.
struct ContactGap {
  double least = std::numeric_limits<double>::infinity();  ///< least distance less the threshold [m]; +infinity if
                                                           ///< nothing is within reach
  double num_points = 0.0;                                 ///< points of the surface rule on which a pressure acts
};

/// What touches, as pairs that the terms of contact, friction and damping have in common: each rank sees those at its
/// own nodes, and counts those whose feature has its first vertex there.
class TouchingBodies final : public PairCoupling {
 public:
  /// `drag`: that of the friction and damping between them, which need the pairs of the configuration at which they are
  /// frozen too; empty: there are none. `penalty`: of such a law.
  TouchingBodies(std::shared_ptr<const BodySurfaces> surfaces, ContactSets sets, BodyContactLaws laws,
                 std::optional<FrictionUpdate> drag = std::nullopt, PenaltyParts penalty = {});

  const Patches& patches() const override { return surfaces_->patches(); }
  /// For a penalty twice as far as its points look, and on the same side, too: a rank has to know everything that may
  /// be nearer to a point than one of its own triangles.
  double reach() const override { return std::max(laws_.reach(), 2.0 * range()); }
  bool may_couple(int tag, int other) const override { return is_penalty() || sets_(tag, other); }
  bool couples(std::int64_t key, std::int64_t other) const override {
    const auto &a = surfaces_->surface().triangles()[key], &b = surfaces_->surface().triangles()[other];
    return !is_penalty() || (a.body != b.body && sets_(a.group, b.group));
  }
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override;
  std::span<const double> frozen_place(const LocalStage& stage, std::span<const double> q) const override;

  const BodySurfaces& surfaces() const { return *surfaces_; }
  /// Whether two triangles are neighbours that do not feel each other.
  bool are_neighbours(std::int32_t triangle, std::int32_t other) const {
    const auto triangles = surfaces_->surface().triangles();
    return neighbours_.include(triangles[triangle].vertices, triangles[other].vertices);
  }

  // The following are of this rank's pairs, with NearPatches found for at least the distance asked for.

  /// The potential of what this rank counts [J].
  double energy(const NearPatches& near, std::span<const double> q) const;
  /// The contact pressure at the vertex of each owned node [Pa]: the force on it over the part of its area that faces
  /// the force, so that at edges and corners of bodies only the facets that touch count.
  std::vector<double> pressures(const NearPatches& near, std::span<const double> q) const;
  /// Calls add_force(node, dU/dx) and add_block(node, node, d2U/dx dx) for local nodes, the first of them owned.
  template <class AddForce, class AddBlock>
  void evaluate(const NearPatches& near, std::span<const double> q, ContactOrder order, const AddForce& add_force,
                const AddBlock& add_block) const;
  /// visit(touch), for each with an owned node.
  template <class Visit>
  void for_each_touch(const NearPatches& near, std::span<const double> q, const Visit& visit) const;

  /// Whether the bodies may pass into each other.
  bool is_penalty() const { return laws_.is_penalty(); }

  /// Short of the first contact of a vertex with a triangle or of two edges on the way from q to q + d, by conservative
  /// advancement; as a fraction of d, +infinity if there is none. With a penalty, when a point is half as deep in
  /// another body as the penalty pushes, if it limits steps.
  double max_step(const NearPatches& near, std::span<const double> q, std::span<const double> d) const;

  /// The gap of what is nearer than `distance` [m], at least the reach; places of one body count if they have come to
  /// less than half of their distance at rest. The distance of a penalty has a sign.
  ContactGap gap(const NearPatches& near, std::span<const double> q, double distance) const;
  /// Lowers the gaps [m] of the owned nodes (all local nodes have one) to those of their vertices.
  void lower_gaps(const NearPatches& near, std::span<const double> q, double distance, std::span<double> gaps) const;
  /// In exact arithmetic; a penalty allows them.
  SurfaceCrossings crossings(const NearPatches& near, std::span<const double> q) const;

 private:
  /// The vertices of the collision surface as a rank sees them: only those at the nodes of triangles near it have a
  /// meaning.
  struct Positions {
    std::vector<Vector3<double>> x, dx;  // and displacements if there are any [m]
  };
  /// Points and triangles, and edges, that may touch; each list is sorted.
  struct Candidates {
    std::vector<BoxPair> points;  // a point of the rule, a triangle
    std::vector<BoxPair> edges;   // the first of the lower number
  };
  /// All candidates of patches that are near one another, and the nodes of their vertices.
  struct Features final : PairFeatures {
    Candidates candidates;
    std::vector<PetscInt> nodes;          // local, of each vertex of the collision surface; -1: unknown
    std::vector<std::int32_t> triangles;  // that are near, ascending
    std::vector<std::int32_t> vertices;   // of the nodes with which these move, ascending
    std::vector<std::int32_t> placed;     // of the triangles themselves, ascending: their positions are complete
  };
  /// What touches in a configuration, and what follows from it.
  struct Configuration {
    std::shared_ptr<const PairFeatures> features;
    std::vector<Vector3<double>> x;
    ContactPairs pairs;
    std::vector<BoxPair> near_points;  // of a penalty with drag: points and all triangles near them
    std::optional<std::vector<Touch>> touches;
  };
  /// The distance within which a penalty looks for what is nearest [m].
  double range() const { return is_penalty() ? std::max(laws_.reach(), penalty_.depth) : 0.0; }
  static const Features& features(const NearPatches& near) { return static_cast<const Features&>(*near.features); }
  Positions positions(const NearPatches& near, std::span<const double> q, std::span<const double> d = {}) const;
  /// What is nearer than `distance` [m] there, or anywhere on the way.
  Candidates candidates(const NearPatches& near, const Positions& at, double distance) const;
  /// ContactGap::least of the candidates.
  double least_gap(const NearPatches& near, const Positions& at, const Candidates& found) const;
  /// Points and triangles of different bodies that are near each other, for a penalty: of all that the rank knows.
  Candidates known_candidates(const NearPatches& near, const Positions& at, double distance) const;
  /// The fraction of the displacements at which a point is too deep in another body; +infinity if none comes there.
  double max_step_of_penalty(const NearPatches& near, Positions at) const;
  /// Likewise, on a short way; 1 if none comes there.
  double step_to_depth(const NearPatches& near, const Positions& at) const;
  /// visit(point, gap) of each point that this rank counts and what is nearest to it in another body, within a distance
  /// [m], for a penalty.
  template <class Visit>
  void for_each_gap(const NearPatches& near, const Positions& at, const Candidates& found, double distance,
                    const Visit& visit) const;
  /// What is within reach of its law.
  std::vector<PointPair> point_pairs_of(const Candidates& found, std::span<const Vector3<double>> x) const;
  std::vector<EdgePair> edge_pairs_of(const Candidates& found, std::span<const Vector3<double>> x) const;
  /// Valid until the next call.
  Configuration& configuration(const NearPatches& near, std::span<const double> q) const;
  const std::vector<Touch>& touches(const NearPatches& near, std::span<const double> q) const;

  std::shared_ptr<const BodySurfaces> surfaces_;
  ContactSets sets_;
  BodyContactLaws laws_, edge_laws_;  // of points at triangles, and of edges across edges
  std::optional<FrictionUpdate> drag_;
  PenaltyParts penalty_;
  SurfaceNeighbours neighbours_;
  FeatureMultiplicities multiplicities_;
  std::vector<SurfacePoint> points_;           // of the rule: corners, then inner points of the triangles
  std::vector<std::int32_t> point_of_corner_;  // of the three corners of each triangle
  std::size_t num_inner_points_ = 0;           // of each triangle
  /// The last configurations: value, gradient and Hessian are evaluated at one of them, and coefficients stay frozen at
  /// another.
  mutable std::array<Configuration, 3> last_;
  mutable std::size_t oldest_ = 0;
};

// ---------------------------------------------------------------------------------------------------------------------

template <class AddForce, class AddBlock>
void TouchingBodies::evaluate(const NearPatches& near, std::span<const double> q, ContactOrder order,
                              const AddForce& add_force, const AddBlock& add_block) const {
  const CollisionSurface& surface = surfaces_->surface();
  const Configuration& now = configuration(near, q);
  const auto& nodes = features(near).nodes;
  const auto force = [&](std::int32_t v, const Vector3<double>& f) {
    const auto of_v = surfaces_->support(v);
    for (int a = 0; a < of_v.size; ++a) {
      if (near.is_owned(nodes[of_v.nodes[a]])) add_force(nodes[of_v.nodes[a]], of_v.weights[a] * f);
    }
  };
  const auto block = [&](std::int32_t v, std::int32_t w, const Tensor3<double>& H) {
    const auto of_v = surfaces_->support(v), of_w = surfaces_->support(w);
    for (int a = 0; a < of_v.size; ++a) {
      if (!near.is_owned(nodes[of_v.nodes[a]])) continue;
      for (int b = 0; b < of_w.size; ++b) {
        add_block(nodes[of_v.nodes[a]], nodes[of_w.nodes[b]], (of_v.weights[a] * of_w.weights[b]) * H);
      }
    }
  };
  add_point_pairs(surface, points_, now.pairs.points, now.x, laws_, order, force, block);
  add_edge_pairs(surface, now.pairs.edges, now.x, edge_laws_, order, force, block);
}

template <class Visit>
void TouchingBodies::for_each_touch(const NearPatches& near, std::span<const double> q, const Visit& visit) const {
  for (const Touch& touch : touches(near, q)) visit(touch);
}

}  // namespace pliant
