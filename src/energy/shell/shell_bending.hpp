/// Bending of thin layers by the angles between neighbouring facets, without rotations as unknowns.
#pragma once

#include "energy/shell/bending_stencils.hpp"
#include "energy/shell/shell_topology.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace pliant {

/// Edges of a layer whose direction across them is held: clamped ones, and those on a plane of symmetry.
struct ClampedEdges {
  EdgeList edges;
  /// The normal of the plane of symmetry in which they may turn; none: the direction of the facet at rest, about an
  /// edge that does not turn.
  std::optional<Vector3<double>> normal;
};

/// The bending of a triangle of a facet, in the axes of space: xx yy zz xy yz xz.
struct BentTriangle {
  PetscInt number = 0;         ///< among the triangles of the layer's facets, facet by facet (facet_triangles.hpp)
  double area = 0.0;           ///< of the triangle at rest [m^2]
  bool is_surrounded = false;  ///< by neighbours at all sides: elsewhere, curvatures at rest are guesses
  std::array<double, 6> curvature{};  ///< of the surface, positive where its outer side is convex [1/m]
  std::array<double, 6> moment{};     ///< per length, positive where the outer side is stretched [N]
};

/// U = sum over triangles of A/2 kappa.C kappa,   kappa = sum_i G_i (theta_i - theta_i^0)
///
/// in the angles theta at the edges of each triangle and of its neighbours (energy/shell/plate_patch.hpp) and those at
/// rest, theta^0: the curvature of the mesh is the natural one. A triangle couples the corners of its neighbours and
/// of theirs, up to 12 nodes; facets of six nodes are four triangles. Edges in which three or more triangles meet, and
/// edges of the surface that are not clamped, carry no moment. U depends on positions alone.
class ShellBending final : public EnergyTerm, public PairCoupling {
 public:
  /// `stiffness` at a reference position. Collective.
  ShellBending(const NodeLayout& layout, const FacetList& facets,
               const std::function<BendingStiffness(const std::array<double, 3>&)>& stiffness,
               std::span<const ClampedEdges> clamped = {});

  const Patches& patches() const override { return patches_; }
  double reach() const override { return 1.0; }
  bool may_couple(int /*tag*/, int /*other*/) const override { return true; }
  const FixedPairs* fixed_pairs() const override { return &fixed_; }
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }

  std::string_view name() const override { return "shell-bending"; }
  TermDeclaration declaration() const override { return {.rotates_with_body = false}; }
  bool has_adjoint() const override { return true; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;

  /// All triangles of the facets of this rank that have an owned node, at displacements q; `near`: as the term has it.
  /// The outer side of a facet is the one that its normal points to; of one between two bodies, the upper one (z; y or
  /// x where it is vertical).
  void visit(const NearPatches& near, std::span<const double> q,
             const std::function<void(const BentTriangle&)>& visitor) const;
  PetscInt num_owned_nodes() const { return num_owned_nodes_; }

  /// How many edges of each of `clamped` do not bound the layer, on all ranks; none where all do.
  const std::map<std::int32_t, std::int64_t>& num_unclamped() const { return topology_.num_unclamped(); }

 private:
  void list_patches(const NodeLayout& layout, const FacetList& facets);
  void fix_pairs();

  PetscInt num_owned_nodes_, first_owned_node_;
  ShellTopology topology_;
  std::vector<BendingStiffness> stiffness_;  // of each triangle
  Patches patches_;
  struct Face {
    PetscInt number = 0;  // among those of the facets
    double sign = 1.0;    // 1 where the normal of the topology's triangle points to the outer side, else -1
  };
  std::map<std::int64_t, Face> faces_;  // by the number of the triangle, of this rank's facets
  FixedPairs fixed_;
};

}  // namespace pliant
