/// Bending of thin layers by the angles between neighbouring facets, without rotations as unknowns.
#pragma once

#include "energy/shell/hinge.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace pliant {

/// A layer's resistance to bending.
struct BendingStiffness {
  double rigidity = 0.0;  ///< D = E h^3 / (12 (1 - nu^2)) [N m]
  double poissons_ratio = 0.0;
};

/// U = sum over triangles of 1/2 sum_ij M_ij (theta_i - theta_i^0) (theta_j - theta_j^0)
///
/// in the angles theta at the edges of each triangle (energy/shell/hinge.hpp) and those at rest, theta^0: the curvature
/// of the mesh is the natural one. A triangle couples the corners of its neighbours; facets of six nodes are four
/// triangles. Edges in which three or more triangles meet, and edges of the surface, carry no moment. U depends on
/// positions alone.
class ShellBending final : public EnergyTerm, public PairCoupling {
 public:
  /// `stiffness` at a reference position. Collective.
  ShellBending(const NodeLayout& layout, const FacetList& facets,
               const std::function<BendingStiffness(const std::array<double, 3>&)>& stiffness);

  const Patches& patches() const override { return patches_; }
  /// Neighbours touch.
  double reach() const override { return 1e-3 * edge_length_; }
  double slack() const override { return 0.5 * edge_length_; }
  bool may_couple(int /*tag*/, int /*other*/) const override { return true; }
  bool couples(std::int64_t key, std::int64_t other) const override;
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

 private:
  /// A triangle of any rank, by global nodes.
  struct Triangle {
    std::array<std::int64_t, 3> nodes{};
    BendingStiffness stiffness;
    std::array<std::int64_t, 3> sorted() const;
  };
  /// A triangle with a node of this rank in its patch.
  struct Stencil {
    /// Local: its corners, then those of its neighbours; -1: none.
    std::array<PetscInt, 6> nodes{-1, -1, -1, -1, -1, -1};
    std::array<double, 9> M{};
    std::array<double, 3> rest{};
    bool is_counted = false;
  };
  struct Seen final : PairFeatures {
    std::vector<Stencil> stencils;
  };
  static const Seen& seen(const NearPatches* near);
  void find_neighbours();
  void list_patches(const NodeLayout& layout, const FacetList& facets);
  static HingeVectors vectors(const Stencil& stencil, std::size_t edge, std::span<const double> X,
                              std::span<const double> q);
  /// theta - theta^0 of all edges.
  static std::array<double, 3> changes(const Stencil& stencil, std::span<const double> X, std::span<const double> q);
  /// The triangle with its neighbours; all nodes -1 where one of those is not among the near patches, `place` by key.
  Stencil stencil_of(std::size_t number, const std::map<std::int64_t, std::size_t>& place,
                     const NearPatches& near) const;

  PetscInt num_owned_nodes_;
  std::vector<Triangle> triangles_;                      // of all ranks, by their sorted nodes
  std::vector<std::array<std::int64_t, 3>> neighbours_;  // across the edge from corner k to k + 1; -1: none
  double edge_length_ = 0.0;                             // the mean [m]
  Patches patches_;
};

}  // namespace pliant
