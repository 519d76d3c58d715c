/// The input's constraints on the mesh.
#pragma once

#include "energy/constraint/constraint_map.hpp"
#include "energy/constraint/prescribed.hpp"
#include "input/config.hpp"
#include "model/constraint_ties.hpp"
#include "model/mechanisms.hpp"
#include "model/selections.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A support: what holds the body in one place, under one name.
struct Support {
  std::string name;
  std::vector<PetscInt> dofs;             ///< owned entries whose reactions it is
  std::optional<std::size_t> rigid_part;  ///< the constraint that makes them rigid
  bool has_ties = false;                  ///< entries depend on others: the torque is not known, unless they are rigid
  bool has_torque() const { return rigid_part.has_value() || !has_ties; }
};

/// The reaction: force and torque of a support on the body, over all ranks.
struct Reaction {
  std::array<double, 3> force{};   ///< [N]
  std::array<double, 3> torque{};  ///< about the centre of a rigid part, or the middle of the bounding box [N m]
};

class Constraints {
 public:
  /// Throws InputError with its errors and those that `selections` has found before. Collective.
  Constraints(const Config& config, const NodeLayout& layout, Selections& selections);
  Constraints(const Constraints&) = delete;  // hooks refer to the object
  Constraints& operator=(const Constraints&) = delete;

  const PrescribedDisplacement& prescribed() const { return *prescribed_; }
  PrescribedDisplacement& prescribed() { return *prescribed_; }
  const std::vector<Support>& supports() const { return supports_; }
  /// One for each constraint of the input, in its order, and more for what it implies.
  const std::vector<ConstraintPart>& parts() const { return parts_; }
  const std::vector<ModelJoint>& joints() const { return joints_; }
  /// Notes of what was tied.
  const std::vector<Diagnostic>& description() const { return description_; }
  /// The map of the ties and rigid parts; nullptr if there are none.
  ConstraintMap* map() const { return map_.get(); }
  /// The hooks of the time layer; they refer to this object.
  PrescribedMotion motion(Correction correction = Correction::nearest) const;
  /// For each local node the number of the rigid part that it belongs to, from 1; 0 if to none. Collective.
  std::vector<int> rigid_parts() const;
  /// Where constraints exert forces.
  enum class Hold : char { none, prescribed, ideal };
  /// For each owned entry, the kind of constraint that holds it; an ideal one does no work but for the error of a step.
  std::vector<Hold> held() const;

  /// Throws InputError at a constraint whose displacement is not finite at the time [s]. Collective.
  void require_finite(double time) const;

  /// Reactions of the supports from the gradient `r` of the potential at q. Collective.
  std::vector<Reaction> reactions(Vec r, Vec q) const;
  /// The same for joints: on their second bodies. Collective.
  std::vector<JointReaction> joint_reactions(Vec r, Vec q) const;

 private:
  using Part = ConstraintPart;

  Part make_part(const Config& input, const ConstraintConfig& constraint, Selections& selections);
  Part plane(const ConstraintConfig& constraint, Selections& selections);
  Part rigid(const Config& input, const ConstraintConfig& constraint, Selections& selections);
  void add_supports(const Config& config);
  /// Adds what joints exert on the rigid parts of supports. `centres`: of their torques [m]. Collective.
  /// About which the torques of the supports are taken, at q. Collective.
  std::vector<Vector3<double>> centres_of_supports(Vec q) const;
  void add_joints(Vec r, Vec q, std::span<const Vector3<double>> centres, std::vector<Reaction>& reactions) const;
  void add_multipliers(Vec r, std::vector<double>& sums) const;
  void add_moments_of_ties(Vec r, Vec q, std::span<const Vector3<double>> centres, std::vector<double>& sums) const;

  const NodeLayout& layout_;
  std::vector<Part> parts_;  // per constraint of the input
  std::unique_ptr<PrescribedDisplacement> prescribed_;
  std::unique_ptr<ConstraintMap> map_;
  std::vector<ModelJoint> joints_;
  std::vector<Support> supports_;
  std::vector<std::size_t> support_of_part_;  // no_support: it was not asked for, and holds nothing
  static constexpr auto no_support = static_cast<std::size_t>(-1);
  std::vector<Diagnostic> description_;
};

}  // namespace pliant
