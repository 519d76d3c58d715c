#include "energy/contact/body_contact.hpp"

#include "base/compensated_sum.hpp"

#include <algorithm>
#include <string_view>

namespace pliant {
namespace {

/// What the terms have in common.
class BodyTerm : public EnergyTerm {
 public:
  BodyTerm(std::shared_ptr<const TouchingBodies> bodies, MeasuredNodes measured)
      : bodies_(std::move(bodies)), measured_(std::move(measured)) {}

  Coupling coupling() const override { return static_cast<const PairCoupling*>(bodies_.get()); }
  bool is_measured_at(PetscInt node) const override { return measured_ == nullptr || (*measured_)[node] != 0; }

 protected:
  const TouchingBodies& bodies() const { return *bodies_; }

 private:
  std::shared_ptr<const TouchingBodies> bodies_;
  MeasuredNodes measured_;
};

class BodyContact final : public BodyTerm {
 public:
  using BodyTerm::BodyTerm;

  std::string_view name() const override { return "contact"; }
  TermDeclaration declaration() const override {
    const bool is_wall = !bodies().is_penalty();
    return {.account = Account::stored, .is_wall = is_wall, .is_two_sided = is_wall};
  }
  bool has_adjoint() const override { return true; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return bodies().energy(*stage.near, q);
  }
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const override {
    return bodies().energy(*at.near, q);
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    bodies().evaluate(
        *stage.near, q, ContactOrder::gradient,
        [&](PetscInt node, const Vector3<double>& f) {
          for (PetscInt i = 0; i < 3; ++i) r[3 * node + i] += f[i];
        },
        [](auto...) {});
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const auto order = projection == Projection::none ? ContactOrder::hessian : ContactOrder::semidefinite_hessian;
    bodies().evaluate(
        *stage.near, q, order, [](auto...) {},
        [&](PetscInt row, PetscInt column, const Tensor3<double>& H) { K.add(row, column, H.a); });
  }

  double max_step(const LocalStage& stage, std::span<const double> q, std::span<const double> d) const override {
    return bodies().max_step(*stage.near, q, d);
  }
};

template <class Drag>
class BodyDrag final : public BodyTerm {
 public:
  /// `damping`: the contact damping of the same bodies, whose pressure adds to the friction.
  BodyDrag(std::shared_ptr<const TouchingBodies> bodies, const Drag& drag, const NormalDamping& damping,
           FrictionUpdate update, MeasuredNodes measured)
      : BodyTerm(std::move(bodies), std::move(measured)), drag_(drag), damping_(damping), update_(update) {}

  std::string_view name() const override { return Drag::name; }
  TermDeclaration declaration() const override {
    return {.has_frozen_coefficients = update_ == FrictionUpdate::frozen,
            .refreezes = update_ == FrictionUpdate::iterated,
            .account = Account::stored,
            .dissipates = true};
  }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return stage.dt * integrate(stage, q, [&](const Touch& touch, double pressure, const Vector3<double>& v) {
             return drag_(pressure, touch.normal, v).potential;
           });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    for_each_touch(stage, q, [&](const Touch& touch, double pressure, const Vector3<double>& v) {
      const Vector3<double> f = touch.area * drag_(pressure, touch.normal, v).slope;
      for (int i = 0; i < touch.num_nodes; ++i) {
        for (PetscInt k = 0; k < 3; ++k) r[3 * touch.nodes[i] + k] += touch.weights[i] * f[k];
      }
    });
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    for_each_touch(stage, q, [&](const Touch& touch, double pressure, const Vector3<double>& v) {
      if (touch.area < 0.0 && projection == Projection::positive_semidefinite) return;
      const Tensor3<double> H = (touch.area / stage.dt) * drag_(pressure, touch.normal, v).hessian;
      for (int i = 0; i < touch.num_nodes; ++i) {
        if (!stage.near_frozen->is_owned(touch.nodes[i])) continue;
        for (int j = 0; j < touch.num_nodes; ++j) {
          K.add(touch.nodes[i], touch.nodes[j], ((touch.weights[i] * touch.weights[j]) * H).a);
        }
      }
    });
  }

  /// A frozen drag: the traction that it exerts, and the one that the pressure at q allows, frozen damping included.
  DragBound bound(const LocalStage& stage, std::span<const double> q) const override {
    if (update_ == FrictionUpdate::iterated) return {};
    CompensatedSum<double> exerted, allowed;
    for_each_touch(stage, q, [&](const Touch& touch, double pressure, const Vector3<double>& v) {
      if (!touch.is_counted) return;
      exerted.add(touch.area * drag_.size(pressure, touch.normal, v));
      if (damping_.damping == 0.0) return;
      const double added = touch.pressure * damping_.added_part(touch.normal, v);
      allowed.add(touch.area * drag_.largest(added, touch.normal, v));
    });
    bodies().for_each_touch(*stage.near, q, [&](const Touch& touch) {
      const Vector3<double> v = (1.0 / stage.dt) * touch.displacement(stage.q0, q);
      if (touch.is_counted) allowed.add(touch.area * drag_.largest(touch.pressure, touch.normal, v));
    });
    return {exerted.total(), std::max(0.0, allowed.total())};
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    return integrate(stage, q, [&](const Touch& touch, double pressure, const Vector3<double>& v) {
      return dot(drag_(pressure, touch.normal, v).slope, v);
    });
  }

 private:
  /// visit(touch, pressure with damping, relative velocity at q) of what is frozen.
  template <class Visit>
  void for_each_touch(const LocalStage& stage, std::span<const double> q, const Visit& visit) const {
    const bool refreezes = update_ == FrictionUpdate::iterated;
    const std::span<const double> at = stage.frozen_at(refreezes, q);
    bodies().for_each_touch(*stage.near_frozen, at, [&](const Touch& touch) {
      double pressure = touch.pressure;
      if (damping_.damping > 0.0) {
        const Vector3<double> v = stage.is_frozen_at_start(refreezes)
                                      ? touch.combine(stage.v0)
                                      : (1.0 / stage.dt) * touch.displacement(stage.q0, at);
        pressure *= 1.0 + damping_.added_part(touch.normal, v);
      }
      visit(touch, pressure, (1.0 / stage.dt) * touch.displacement(stage.q0, q));
    });
  }

  template <class Density>
  double integrate(const LocalStage& stage, std::span<const double> q, const Density& density) const {
    CompensatedSum<double> total;
    for_each_touch(stage, q, [&](const Touch& touch, double pressure, const Vector3<double>& v) {
      if (touch.is_counted) total.add(touch.area * density(touch, pressure, v));
    });
    return total.total();
  }

  Drag drag_;
  NormalDamping damping_;
  FrictionUpdate update_;
};

}  // namespace

std::unique_ptr<EnergyTerm> make_body_contact(std::shared_ptr<const TouchingBodies> bodies, MeasuredNodes measured) {
  return std::make_unique<BodyContact>(std::move(bodies), std::move(measured));
}

std::unique_ptr<EnergyTerm> make_body_friction(std::shared_ptr<const TouchingBodies> bodies, const Friction& friction,
                                               const NormalDamping& damping, FrictionUpdate update,
                                               MeasuredNodes measured) {
  return std::make_unique<BodyDrag<Friction>>(std::move(bodies), friction, damping, update, std::move(measured));
}

std::unique_ptr<EnergyTerm> make_body_damping(std::shared_ptr<const TouchingBodies> bodies,
                                              const NormalDamping& damping, FrictionUpdate update,
                                              MeasuredNodes measured) {
  return std::make_unique<BodyDrag<NormalDamping>>(std::move(bodies), damping, NormalDamping{}, update,
                                                   std::move(measured));
}

}  // namespace pliant
