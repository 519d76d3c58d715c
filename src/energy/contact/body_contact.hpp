/// Contact of bodies with one another and with themselves: a term of pairs of surface triangles.
#pragma once

#include "collision/contact_pairs.hpp"
#include "energy/contact/body_surfaces.hpp"
#include "energy/term.hpp"
#include "material/contact_law.hpp"

#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// The contact law of each two bodies (FacetSide::body): a symmetric matrix by rows.
struct BodyContactLaws {
  int num_bodies = 1;
  std::vector<NormalLaw> of_bodies;

  const NormalLaw& of(int body, int other) const { return of_bodies[num_bodies * body + other]; }
  NormalResponse operator()(int body, int other, double distance) const { return of(body, other)(distance); }
  /// The greatest distance at which one of them acts [m].
  double reach() const;
};

/// The gap of surfaces that may touch.
struct ContactGap {
  double least = std::numeric_limits<double>::infinity();  ///< least distance less the threshold [m]; +infinity if
                                                           ///< nothing is within reach
  double num_points = 0.0;                                 ///< points of the surface rule on which a pressure acts
};

/// Edges that pass through triangles, where bodies overlap.
struct SurfaceCrossings {
  int count = 0;
  Vector3<double> place{};  ///< of one of them [m]
  int body = 0, other = 0;  ///< whose surfaces cross there
};

/// The potential of collision/contact_pairs over the surfaces as they are deformed, with barriers alone: distances have
/// no sign, so that a penalty would push what has passed through further on.
///
/// Bodies start apart and stay so: no Newton step moves a vertex through a triangle or an edge through an edge
/// (`max_step`), and pressures grow without bound as gaps close. Each rank evaluates the pairs at its own nodes and
/// counts the energy of those whose feature has its first vertex there. Derivatives are exact; the energy has two
/// continuous ones but where a closest point passes from a feature to its neighbour at an angle, where it has one.
class BodyContact final : public EnergyTerm, public PairCoupling {
 public:
  /// Throws std::invalid_argument for a penalty.
  BodyContact(std::shared_ptr<const BodySurfaces> surfaces, ContactSets sets, BodyContactLaws laws);

  const Patches& patches() const override { return surfaces_->patches(); }
  double reach() const override { return laws_.reach(); }
  bool may_couple(int tag, int other) const override { return sets_(tag, other); }

  std::string_view name() const override { return "contact"; }
  TermDeclaration declaration() const override { return {.account = Account::stored, .is_wall = true}; }
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;
  /// Short of the first contact of a vertex with a triangle or of two edges, by conservative advancement.
  double max_step(const LocalStage& stage, std::span<const double> q, std::span<const double> d) const override;

  // The following measure this rank's pairs, with NearPatches found for at least the distance asked for.

  /// The gap of what is nearer than `distance` [m], at least the reach; places of one body count if they have come to
  /// less than half of their distance at rest.
  ContactGap gap(const NearPatches& near, std::span<const double> q, double distance) const;
  /// Lowers the gaps [m] of the owned nodes (all local nodes have one) to those of their vertices.
  void lower_gaps(const NearPatches& near, std::span<const double> q, double distance, std::span<double> gaps) const;
  /// In exact arithmetic.
  SurfaceCrossings crossings(const NearPatches& near, std::span<const double> q) const;
  double energy(const NearPatches& near, std::span<const double> q) const;

  const BodySurfaces& surfaces() const { return *surfaces_; }

 private:
  struct Near;
  /// What is nearer than `distance` [m] at q, or anywhere between q and q + d.
  Near near_at(const NearPatches& near, double distance, std::span<const double> q,
               std::span<const double> d = {}) const;
  ContactPairs pairs_of(const Near& near) const;
  /// Evaluates all pairs at q: AddForce and AddBlock as those of add_point_pairs, with local nodes.
  template <class AddForce, class AddBlock>
  void evaluate(const NearPatches& near, std::span<const double> q, ContactOrder order, const AddForce& add_force,
                const AddBlock& add_block) const;

  std::shared_ptr<const BodySurfaces> surfaces_;
  ContactSets sets_;
  BodyContactLaws laws_;
  FeatureMultiplicities multiplicities_;
  std::vector<SurfacePoint> points_;           // of the rule: corners, then inner points of the triangles
  std::vector<std::int32_t> point_of_corner_;  // of the three corners of each triangle
  std::size_t num_inner_points_ = 0;           // of each triangle
};

}  // namespace pliant
