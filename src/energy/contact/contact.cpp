#include "energy/contact/contact.hpp"

#include "base/compensated_sum.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using ContactPoint = ContactSurface::Point;
using Facets = ContactSurface::Facets;

/// The fraction of a point's distance to the obstacle by which one step may approach it.
constexpr double least_gap_left = 0.1;
constexpr int max_advances = 100;

/// The displacement of a point from one configuration to another, accurate relative to the difference.
Vector3<double> way_of(const ContactPoint& point, std::span<const double> from, std::span<const double> to) {
  Vector3<double> dx{};
  for (std::size_t a = 0; a < point.nodes.size(); ++a) {
    const PetscInt n = 3 * point.nodes[a];
    for (std::size_t i = 0; i < 3; ++i) dx[i] += point.N[a] * (to[n + i] - from[n + i]);
  }
  return dx;
}

/// d(x + dx) - d(x), accurate relative to dx where the distance is smooth: a body at rest moves by less than the
/// rounding error of its position.
double distance_change(const ObstacleFrame& obstacle, const Vector3<double>& x, const Vector3<double>& dx) {
  constexpr double rounding = 20.0 * std::numeric_limits<double>::epsilon();
  const Vector3<double> end = x + dx;
  const DistanceAt from = obstacle.at(x), to = obstacle.at(end);
  const double difference = to.d - from.d;
  // Simpson's rule for int n . dx, unless its error is visible.
  const double along = dot(from.n + 4.0 * obstacle.at(x + 0.5 * dx).n + to.n, dx) / 6.0;
  const double size = norm(x) + norm(end) + std::abs(from.d) + std::abs(to.d);
  return std::abs(along - difference) <= rounding * size ? along : difference;
}

/// U(d + delta) - U(d), accurate relative to delta: -int p, by Gauss's rule with three points, which is exact for a
/// penalty between its joints, and for short distances in a barrier.
double energy_change(const NormalLaw& law, double d, double delta) {
  const double reach = law.reach();
  if (delta == 0.0 || std::min(d, d + delta) >= reach) return 0.0;
  constexpr double short_way = 0.02;
  if (law.kind == NormalKind::barrier && std::abs(delta) > short_way * (std::min(d, d + delta) - law.threshold)) {
    return law(d + delta).energy - law(d).energy;
  }
  // The intervals between the distances at which the law changes.
  const auto part = [&](double joint) { return std::clamp((joint - d) / delta, 0.0, 1.0); };
  std::array<double, 4> ends{0.0, part(reach), part(law.linear_from()), 1.0};
  if (ends[1] > ends[2]) std::swap(ends[1], ends[2]);
  const double node = std::sqrt(0.6);
  double sum = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double length = ends[k + 1] - ends[k], middle = d + 0.5 * (ends[k] + ends[k + 1]) * delta;
    if (length == 0.0) continue;
    const double aside = 0.5 * length * delta * node;
    sum -= length * delta *
           (4.0 / 9 * law(middle).pressure + 5.0 / 18 * (law(middle - aside).pressure + law(middle + aside).pressure));
  }
  return sum;
}

}  // namespace

double Contact::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  CompensatedSum<double> total;
  const ObstacleFrame frame = obstacle_->at(at);
  surface_->for_each_near(frame, {q}, Facets::owned, [&](const ContactPoint& point) {
    total.add(point.area * surface_->law()(frame.distance(surface_->position(point, q))).energy);
  });
  return total.total();
}

double Contact::value(const LocalStage& stage, std::span<const double> q) const {
  CompensatedSum<double> total;
  const ObstacleFrame frame = obstacle_->at(instant_of(stage));
  const NormalLaw& law = surface_->law();
  surface_->for_each_near(frame, {q, stage.q0}, Facets::owned, [&](const ContactPoint& point) {
    const Vector3<double> start = surface_->position(point, stage.q0);
    const double d0 = frame.distance(start);
    double change = 0.0;
    if (law.kind == NormalKind::barrier && d0 <= law.threshold) {
      // The start of a stage, an extrapolation, may lie beyond a barrier. Its energy is a constant of the stage.
      change = law(frame.distance(surface_->position(point, q))).energy;
    } else {
      change = energy_change(law, d0, distance_change(frame, start, way_of(point, stage.q0, q)));
    }
    total.add(point.area * change);
  });
  return total.total();
}

void Contact::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const ObstacleFrame frame = obstacle_->at(instant_of(stage));
  surface_->for_each_near(frame, {q}, Facets::with_owned_nodes, [&](const ContactPoint& point) {
    const DistanceAt at = frame.at(surface_->position(point, q));
    if (at.d >= surface_->law().reach()) return;
    ContactSurface::add_force(point, (-point.area * surface_->law()(at.d).pressure) * at.n, r);
  });
}

void Contact::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                          Projection projection) const {
  const ObstacleFrame frame = obstacle_->at(instant_of(stage));
  surface_->for_each_near(frame, {q}, Facets::with_owned_nodes, [&](const ContactPoint& point) {
    const DistanceAt at = frame.at(surface_->position(point, q));
    if (at.d >= surface_->law().reach()) return;
    const NormalResponse response = surface_->law()(at.d);
    const bool bends = projection == Projection::none || trace(at.curvature) < 0.0;
    const double p = bends ? response.pressure : 0.0;
    surface_->add_stiffness(point, make_tensor([&](int i, int j) {
                              return point.area * (response.stiffness * at.n[i] * at.n[j] - p * at.curvature(i, j));
                            }),
                            K);
  });
}

double Contact::supply(const LocalStage& stage, std::span<const double> q) const {
  if (!obstacle_->moves()) return 0.0;
  CompensatedSum<double> total;
  const ObstacleFrame frame = obstacle_->at(instant_of(stage), stage.dt);
  surface_->for_each_near(frame, {q}, Facets::owned, [&](const ContactPoint& point) {
    const Vector3<double> x = surface_->position(point, q);
    const DistanceAt at = frame.at(x);
    total.add(point.area * surface_->law()(at.d).pressure * dot(at.n, frame.velocity(x)));
  });
  return total.total();
}

double Contact::max_step(const LocalStage& stage, std::span<const double> q, std::span<const double> d) const {
  double bound = std::numeric_limits<double>::infinity();
  if (surface_->law().kind != NormalKind::barrier) return bound;
  const ObstacleFrame frame = obstacle_->at(instant_of(stage));
  surface_->for_each_owned([&](const ContactPoint& point) {
    const Vector3<double> x = surface_->position(point, q), way = ContactSurface::interpolate(point, d);
    const double length = norm(way);
    const double start = frame.distance(x) - surface_->law().threshold;
    if (!(start < length) || length == 0.0) return;
    double alpha = 0.0, clear = start;
    for (int i = 0; i < max_advances && alpha < bound && clear > least_gap_left * start; ++i) {
      alpha += (clear - 0.5 * least_gap_left * start) / length;
      if (alpha > 2.0) return;  // farther than any step goes
      clear = frame.distance(x + alpha * way) - surface_->law().threshold;
    }
    bound = std::min(bound, alpha);
  });
  return bound;
}

void Contact::follow_obstacle(const LocalStage& stage, std::span<Vector3<double>> displacements,
                              std::span<double> closeness) const {
  if (surface_->law().kind != NormalKind::barrier || !obstacle_->moves() || stage.accepted.empty()) return;
  constexpr double near_multiple = 2.0, far_multiple = 5.0;
  const ObstacleFrame start = obstacle_->at(Instant{stage.step_start, stage.load_factor});
  const ObstacleFrame end = obstacle_->at(instant_of(stage));
  const auto moved = [&](const Vector3<double>& x) { return end.place(start.in_shape(x)) - x; };
  const auto closeness_at = [&](const Vector3<double>& x) {
    const double length = norm(moved(x)), gap = std::max(0.0, start.distance(x) - surface_->law().threshold);
    return length > 0.0 ? std::clamp((far_multiple - gap / length) / (far_multiple - near_multiple), 0.0, 1.0) : 0.0;
  };
  const auto follow = [&](PetscInt node, double near) {
    const auto a = static_cast<std::size_t>(node);
    if (near <= closeness[a]) return;
    displacements[a] = moved(surface_->position(node, stage.accepted));
    closeness[a] = near;
  };
  for (std::size_t a = 0; a < displacements.size(); ++a) {
    const auto node = static_cast<PetscInt>(a);
    follow(node, closeness_at(surface_->position(node, stage.accepted)));
  }
  // Between its nodes a curved facet may be nearer than they are.
  const auto follow_at = [&](const ContactPoint& point) {
    const double near = closeness_at(surface_->position(point, stage.accepted));
    for (const PetscInt node : point.nodes) follow(node, near);
  };
  surface_->for_each_near(start, {stage.accepted}, Facets::with_owned_nodes, follow_at);
}

namespace {

template <class Drag>
class ContactDrag final : public EnergyTerm {
 public:
  /// `damping`: the contact damping of the same obstacle, whose pressure adds to the friction.
  ContactDrag(std::shared_ptr<const ContactSurface> surface, std::shared_ptr<const Obstacle> obstacle, const Drag& drag,
              const NormalDamping& damping, FrictionUpdate update)
      : surface_(std::move(surface)), obstacle_(std::move(obstacle)), drag_(drag), damping_(damping), update_(update) {}

  std::string_view name() const override { return Drag::name; }
  TermDeclaration declaration() const override {
    return {.has_frozen_coefficients = update_ == FrictionUpdate::frozen,
            .refreezes = update_ == FrictionUpdate::iterated,
            .account = Account::stored,
            .dissipates = true};
  }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return stage.dt * integrate(stage, q, [&](const Touch& touch, const Vector3<double>& v) {
             const auto start = drag_(touch.pressure, touch.n, -1.0 * touch.obstacle_velocity);
             return drag_(touch.pressure, touch.n, v).potential - start.potential;
           });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    for_each_touch(stage, q, Facets::with_owned_nodes, [&](const Touch& touch, const Vector3<double>& v) {
      ContactSurface::add_force(touch.point, touch.point.area * drag_(touch.pressure, touch.n, v).slope, r);
    });
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection /*projection*/) const override {
    for_each_touch(stage, q, Facets::with_owned_nodes, [&](const Touch& touch, const Vector3<double>& v) {
      const Tensor3<double> H = drag_(touch.pressure, touch.n, v).hessian;
      surface_->add_stiffness(touch.point, (touch.point.area / stage.dt) * H, K);
    });
  }

  /// A frozen drag: the traction that it exerts, and the one that the pressure at q allows, frozen damping included.
  DragBound bound(const LocalStage& stage, std::span<const double> q) const override {
    if (update_ == FrictionUpdate::iterated) return {};
    CompensatedSum<double> exerted, allowed;
    const ObstacleFrame now = obstacle_->at(instant_of(stage), stage.dt);
    const NormalLaw& law = surface_->law();
    for_each_touch(stage, q, Facets::owned, [&](const Touch& touch, const Vector3<double>& v) {
      exerted.add(touch.point.area * drag_.size(touch.pressure, touch.n, v));
    });
    surface_->for_each_near(now, {q}, Facets::owned, [&](const ContactPoint& point) {
      const Vector3<double> x = surface_->position(point, q);
      const DistanceAt at = now.at(x);
      const double pressure = law(at.d).pressure;
      if (!(pressure > 0.0)) return;
      const Vector3<double> v = (1.0 / stage.dt) * way_of(point, stage.q0, q) - now.velocity(x);
      allowed.add(point.area * drag_.largest(pressure, at.n, v));
    });
    if (damping_.damping > 0.0) {
      for_each_touch(stage, q, Facets::owned, [&](const Touch& touch, const Vector3<double>& v) {
        const double added = touch.undamped * damping_.added_part(touch.n, v);
        allowed.add(touch.point.area * drag_.largest(added, touch.n, v));
      });
    }
    return {exerted.total(), std::max(0.0, allowed.total())};
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    return integrate(stage, q, [&](const Touch& touch, const Vector3<double>& v) {
      return dot(drag_(touch.pressure, touch.n, v).slope, v);
    });
  }

  /// The power that the moving obstacle supplies through the drag.
  double supply(const LocalStage& stage, std::span<const double> q) const override {
    return integrate(stage, q, [&](const Touch& touch, const Vector3<double>& v) {
      return -dot(drag_(touch.pressure, touch.n, v).slope, touch.obstacle_velocity);
    });
  }

 private:
  /// A point with its frozen pressure and normal.
  struct Touch {
    const ContactPoint& point;
    double undamped;  // without the pressure of damping
    double pressure;  // total
    Vector3<double> n, obstacle_velocity;
  };

  /// visit(touch, velocity relative to the obstacle) where the frozen pressure is positive.
  template <class Visit>
  void for_each_touch(const LocalStage& stage, std::span<const double> q, Facets which, const Visit& visit) const {
    const bool refreezes = update_ == FrictionUpdate::iterated, at_start = stage.is_frozen_at_start(refreezes);
    const std::span<const double> at = stage.frozen_at(refreezes, q);
    const double start = stage.accepted.empty() ? stage.time - stage.dt : stage.step_start;
    const ObstacleFrame now = obstacle_->at(instant_of(stage), stage.dt);
    const ObstacleFrame frozen =
        at_start ? obstacle_->at(Instant{start, stage.load_factor}) : obstacle_->at(instant_of(stage));
    surface_->for_each_near(frozen, {at}, which, [&](const ContactPoint& point) {
      const Vector3<double> x = surface_->position(point, at);
      const DistanceAt distance = frozen.at(x);
      const double pressure = surface_->law()(distance.d).pressure;
      // Beyond a barrier the pressure is undefined.
      if (!(pressure > 0.0)) return;
      const Vector3<double> moved = way_of(point, stage.q0, q);
      Touch touch{point, pressure, pressure, distance.n, now.velocity(x)};
      if (damping_.damping > 0.0) {
        const Vector3<double> v =
            at_start ? ContactSurface::interpolate(point, stage.v0) : (1.0 / stage.dt) * way_of(point, stage.q0, at);
        touch.pressure *= 1.0 + damping_.added_part(touch.n, v - touch.obstacle_velocity);
      }
      visit(touch, (1.0 / stage.dt) * moved - touch.obstacle_velocity);
    });
  }

  template <class Density>
  double integrate(const LocalStage& stage, std::span<const double> q, const Density& density) const {
    CompensatedSum<double> total;
    for_each_touch(stage, q, Facets::owned, [&](const Touch& touch, const Vector3<double>& v) {
      total.add(touch.point.area * density(touch, v));
    });
    return total.total();
  }

  std::shared_ptr<const ContactSurface> surface_;
  std::shared_ptr<const Obstacle> obstacle_;
  Drag drag_;
  NormalDamping damping_;
  FrictionUpdate update_;
};

}  // namespace

std::unique_ptr<EnergyTerm> make_friction(std::shared_ptr<const ContactSurface> surface,
                                          std::shared_ptr<const Obstacle> obstacle, const Friction& friction,
                                          const NormalDamping& damping, FrictionUpdate update) {
  return std::make_unique<ContactDrag<Friction>>(std::move(surface), std::move(obstacle), friction, damping, update);
}

std::unique_ptr<EnergyTerm> make_normal_damping(std::shared_ptr<const ContactSurface> surface,
                                                std::shared_ptr<const Obstacle> obstacle, const NormalDamping& damping,
                                                FrictionUpdate update) {
  return std::make_unique<ContactDrag<NormalDamping>>(std::move(surface), std::move(obstacle), damping, NormalDamping{},
                                                      update);
}

}  // namespace pliant
