/// Springs, dampers, motors, stops and friction of joints: torques about an axis, and forces along it.
#pragma once

#include "base/expression.hpp"
#include "energy/rigid/joint_coordinate.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"

#include <memory>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

namespace pliant {

/// k/2 (s - rest)^2.
struct JointSpring {
  double stiffness = 0.0, rest = 0.0;
};
/// Resists the rate by c s'.
struct JointDamper {
  double coefficient = 0.0;
};
/// Exerts sat(k (target - s) + d (target' - s')) + effort, sat(u) = limit tanh(u / limit). Its account is that of
/// loads.
struct JointMotor {
  Expression target;
  double stiffness = 0.0, damping = 0.0;
  std::optional<double> limit;
  Expression effort;
};
/// Elastic stops at both ends of a range: an effort k g where the coordinate is beyond one by g, which begins smoothly
/// within `rounding` (k g^2 / (2 rounding), then k (g - rounding / 2)).
struct JointStops {
  double low = 0.0, high = 0.0;
  double stiffness = 0.0, rounding = 0.0;
};
/// Dry friction: an effort against the rate, `largest` where it slides, sat(rate) = largest tanh(rate / stick_rate).
struct JointFriction {
  double largest = 0.0, stick_rate = 0.0;
};
/// As JointFriction, with a largest effort that follows from the load in the bearing (JointBearings). It is frozen
/// while a stage is solved (TermDeclaration::refreezes).
struct BearingFriction {
  std::shared_ptr<const double> largest;
  double stick_rate = 0.0;
};
using JointLaw = std::variant<JointSpring, JointDamper, JointMotor, JointStops, JointFriction, BearingFriction>;

/// What the rate of a coordinate is in a stage.
enum class JointRates {
  derivatives,  ///< ds (q - q0) / dt: of the order of every method; what depends on it has no potential
  differences   ///< (s(q) - s(q0)) / dt, where q0 is a state (backward Euler): everything has a potential
};

/// The effort of a law on the coordinate, and its derivatives.
struct JointEffortValue {
  double effort = 0.0, by_coordinate = 0.0, by_rate = 0.0;
};
/// `factor`: the part of a load step that is reached; it multiplies targets and efforts of motors.
JointEffortValue joint_effort(const JointLaw& law, double coordinate, double rate, double time, double factor);

/// A body as the corners of one of its cells, which move affinely with it.
struct JointBody {
  int key = 0;                  ///< of the body, the same on every rank
  std::vector<PetscInt> nodes;  ///< 4 local ones; empty where none is of this rank
  bool is_owned = false;        ///< exactly one rank counts what is summed over bodies
};
/// The first cell of a body. Collective.
JointBody joint_body(const NodeLayout& layout, const std::vector<int>& body_of_cell, int body);

/// A law of one kind at some joints. Forces act on the corners of a cell of each body, which may be another rank's.
class JointEffort final : public EnergyTerm, public PairCoupling {
 public:
  struct Joint {
    std::array<int, 2> bodies{-1, -1};  ///< keys; -1: the ground
    JointCoordinate coordinate;
    JointLaw law;  ///< all of the same kind
    /// The angle of the last accepted state, whose whole turns count; none: those of the angle in [-pi, pi].
    std::shared_ptr<const double> angle = nullptr;
  };
  JointEffort(const std::vector<JointBody>& bodies, std::vector<Joint> joints,
              JointRates rates = JointRates::derivatives);

  const Patches& patches() const override { return patches_; }
  /// Bodies of a joint are near each other wherever they are.
  double reach() const override { return 1e9; }
  bool may_couple(int tag, int other) const override;

  std::string_view name() const override;
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;

 private:
  /// A joint whose bodies this rank sees.
  struct Seen {
    const Joint* joint = nullptr;
    std::array<std::vector<PetscInt>, 2> nodes;  // none of the ground
    bool is_counted = false;
  };
  std::vector<Seen> seen(const NearPatches& near) const;
  /// All of a kind, as the first one.
  const JointLaw& law() const { return joints_.front().law; }

  std::vector<Joint> joints_;
  JointRates rates_;
  Patches patches_;
};

}  // namespace pliant
