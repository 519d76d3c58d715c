/// Points of reference in the mean (distributing coupling, RBE3): a rigid body that follows the mean motion of a
/// surface.
#pragma once

#include "energy/rigid/joint_effort.hpp"
#include "energy/rigid/surface_mean.hpp"
#include "energy/term.hpp"

#include <string_view>
#include <vector>

namespace pliant {

/// Couples the mean motion of a surface with a rigid body, and leaves the surface free to deform (distributing
/// coupling, RBE3). The body moves by x_b(X) with the gradient F. With the means over the reference surface, of its
/// middle X_m and second moments J (energy/rigid/surface_mean.hpp),
///
///   d = <x> - x_b(X_m),   M = <x (X - X_m)^T>,   a = axial(M^T F),   axial(A)_i = e_imn A_mn,
///   V = k/2 (d . d + a . J_r^-1 a),   J_r = tr(J) I - J.
///
/// a = 0 if the rotation that fits the surface best (least squares) is F: then F^T M is symmetric. Where the surface
/// has turned by a small angle theta from the body, a = J_r theta: V is the energy of a bed of springs of the total
/// stiffness k, uniform over the surface, of which only the mean counts. d and a do not change when everything moves
/// rigidly: what acts on the body and on the surface has neither resultant nor moment. The forces on the surface are
/// those of a traction that is linear in X. V is a polynomial in the nodes' positions, and depends on them alone.
///
/// All nodes of the surface couple with one another: the Hessian has a dense block.
class DistributingCoupling final : public EnergyTerm, public PairCoupling {
 public:
  /// `surface`: not a line. `body`: none of its nodes belongs to the surface. `stiffness`: k [N/m], > 0. Collective.
  DistributingCoupling(const NodeLayout& layout, const SurfaceMean& surface, const JointBody& body, double stiffness);

  const Patches& patches() const override { return patches_; }
  /// All nodes are near one another wherever they are.
  double reach() const override { return 1e9; }
  bool may_couple(int tag, int other) const override { return tag == original || other == original; }
  bool couples(std::int64_t key, std::int64_t other) const override;
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override;

  std::string_view name() const override { return "distributing-coupling"; }
  TermDeclaration declaration() const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;

 private:
  /// The part of a node x in d = sum c x, M = sum x b^T, F = sum x g^T.
  struct Member {
    PetscInt global_node = 0;
    double c = 0.0;
    Vector3<double> b{}, g{};  // [m], [1/m]
  };
  /// d, M - J and F - I, or the changes of all three.
  struct Motion {
    Vector3<double> d{};
    Tensor3<double> H{}, G{};
  };
  /// Patches of four nodes of one rank. Each stands there twice, the second time to couple with the first alone: nodes
  /// of a patch couple, too.
  static constexpr int nodes_per_patch = 4, original = 0, copy = 1;

  void make_patches(const NodeLayout& layout);
  /// The local nodes of all members; empty on a rank that has none.
  static std::span<const PetscInt> nodes(const NearPatches& near);
  /// At q, or the change from another configuration.
  Motion motion(const NearPatches& near, std::span<const double> q, std::span<const double> from = {}) const;
  Vector3<double> turn(const Motion& at) const;

  std::vector<Member> members_;  // of all ranks, by patches
  Tensor3<double> J_, inverse_;  // and J_r^-1
  double stiffness_;
  bool is_counted_ = false;  // by this rank
  Patches patches_;
};

}  // namespace pliant
