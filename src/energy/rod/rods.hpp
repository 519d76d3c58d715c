/// Slender rods: stretch, bending and twist of chains of segments (discrete elastic rods).
#pragma once

#include "energy/rod/rod_stencil.hpp"
#include "energy/rod/rod_strains.hpp"
#include "energy/term.hpp"
#include "energy/volume/affine_bodies.hpp"
#include "energy/volume/mass_matrix.hpp"
#include "fem/layout.hpp"

#include <array>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace pliant {

/// A segment of a rod, or the section at an end that is held: a tetrahedron of nodes x_0, x_1, p_1, p_2
/// (mesh/rod_chain.hpp). It moves affinely, and its columns are the images of the axes of its frame at rest,
/// t = F axes_0, d_1 = F axes_1, d_2 = F axes_2.
struct RodSegment {
  std::array<Vector3<double>, 4> corners{};  ///< x_0, x_1, p_1, p_2 at rest [m]
  double length = 0.0;                       ///< 0 of a section, which has no energy of its own [m]
  double axial = 0.0;                        ///< E A [N]
  double distortion = 0.0;                   ///< stiffness against distortions of the frame [N]
  double mass = 0.0;                         ///< [kg]
  std::array<double, 3> second_moments{};    ///< int X_i^2 dm along the axes of the frame, about the centre [kg m^2]
  double damping = 0.0;                      ///< viscous resistance per stiffness [s]
};

/// Where two segments meet: the one before and the one after, in the order of the rod.
struct RodVertex {
  std::size_t first = 0;            ///< number of the first segment; that of the second is one more
  double length = 0.0;              ///< half of both segments' lengths [m]
  std::array<double, 2> bending{};  ///< E I of bending in the planes of t and d_1, and of t and d_2 [N m^2]
  double torsion = 0.0;             ///< G J [N m^2]
  double damping = 0.0;             ///< viscous resistance per stiffness [s]
};

/// All rods of a model. Their energy is
///
///     U = sum_segments l/2 (E A (|t| - 1)^2 + k sum distortions^2)
///       + sum_vertices 1/(2 l) (E I_1 (kappa_1 - kappa_1^0)^2 + E I_2 (kappa_2 - kappa_2^0)^2 + G J (m - m^0)^2),
///
/// with the strains of energy/rod/rod_strains.hpp; those at rest are in the reference configuration. In the sum of the
/// distortions (d_1 . d_2)^2 counts half, so that it is the same for any two axes of a round section. The distortions
/// keep t, d_1 and d_2 at right angles and of unit length: nothing else acts on them but inertia, so they vanish in
/// equilibrium whatever k is. U depends on positions alone, and does not change in rigid motions: every method keeps
/// its order, and momenta are conserved.
class Rods final : public EnergyTerm, public PairCoupling {
 public:
  /// `segments` are the same on every rank. `segment_of_cell`: the number of the segment that a local cell is; -1: it
  /// is none. Middles of edges that only they have (quadratic elements) are held between the ends by springs, without
  /// mass: they stay there. Collective.
  Rods(const NodeLayout& layout, std::vector<std::ptrdiff_t> segment_of_cell, std::vector<RodSegment> segments,
       std::vector<RodVertex> vertices);

  const Patches& patches() const override { return patches_; }
  double reach() const override { return 1.0; }
  bool may_couple(int /*tag*/, int /*other*/) const override { return true; }
  const FixedPairs* fixed_pairs() const override { return &fixed_; }
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override;
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }

  std::string_view name() const override { return "rods"; }
  TermDeclaration declaration() const override;
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;

  /// Adds their mass: exact for a mass along the axis and second moments of the section. Not collective.
  void add_masses(const BlockPattern& pattern, MassMatrix& mass) const;
  /// What uniform accelerations act on, of this rank's nodes; `of_segments`: one flag per segment. Not collective.
  std::vector<MassAtNode> masses(std::span<const char> of_segments) const;

  std::size_t num_segments() const { return segments_.size(); }
  /// A segment and its local nodes; those of which this rank has no cell come last.
  struct SegmentNodes {
    std::size_t number = 0;
    std::array<PetscInt, 4> nodes{};
    bool is_counted = false;  ///< on exactly one rank
  };
  /// Those with a node of this rank, by their numbers.
  std::vector<SegmentNodes> segments_here() const;
  /// E A (|t| - 1) of one of them at displacements u of the local nodes [N].
  double tension(const SegmentNodes& of, std::span<const double> u) const;
  /// The moments that the vertices counted by this rank carry at displacements q: bending in both planes, and the
  /// torque about the axis, by their numbers, zero of others [N m]. `near`: as the term has it.
  std::vector<std::array<double, 3>> moments(const NearPatches& near, std::span<const double> q) const;
  /// Turns the frames of segments to where the ends and the first directors' points are at displacements q: a formula
  /// of the position bends the axis, and shears the sections, which stay across the axis. Collective.
  void turn_frames(Vec q) const;
  /// The length of a segment at rest [m].
  double length_of(std::size_t segment) const { return segments_[segment].length; }
  /// The number of the vertex after a segment; -1: none.
  std::ptrdiff_t vertex_after(std::size_t segment) const { return vertex_after_[segment]; }
  /// The segment of each local cell; -1: none.
  const std::vector<std::ptrdiff_t>& segment_of_cell() const { return segment_of_cell_; }

 private:
  friend class RodViscosity;
  /// The axes of a segment's frame at rest, and how its columns follow from displacements: h_i = sum_a w_ai u_a.
  struct Frame {
    std::array<Vector3<double>, 3> axes{};
    std::array<std::array<double, 3>, 4> weights{};  // [1/m]
  };
  /// The middle of an edge from a to b: local nodes.
  struct Middle {
    PetscInt node = 0, a = 0, b = 0;
    double stiffness = 0.0;  // [N/m]
  };
  /// `nodes`: of a cell; `is_others`: one flag per local node, those of other cells.
  void add_middles(std::span<const PetscInt> nodes, std::span<const char> is_others, double stiffness);
  /// u of the middle without the mean of the ends'.
  static Vector3<double> offset(const Middle& middle, std::span<const double> q);
  struct Seen final : PairFeatures {
    std::vector<SegmentNodes> segments;                 // with a node of this rank, or next to one
    std::vector<std::array<SegmentNodes, 2>> vertices;  // of which this rank sees both segments
  };
  static const Seen& seen(const NearPatches* near);

  std::array<Vector3<double>, 3> change_of_columns(const SegmentNodes& of, std::span<const double> q) const;
  std::array<double, 6> strains_of(const SegmentNodes& of, std::span<const double> q) const;
  std::array<double, 6> stiffness_of(const SegmentNodes& of) const;
  std::array<double, 3> strains_of(const std::array<SegmentNodes, 2>& of, std::span<const double> q) const;
  std::array<double, 3> stiffness_of(std::size_t vertex) const;
  /// The nodes of a segment or a vertex, the change of its variables since `from`, and its strains at q with their
  /// stiffness.
  template <std::size_t Vectors, std::size_t Nodes, std::size_t Strains, int order>
  struct Stencil {
    std::array<StencilNode<Vectors>, Nodes> nodes;
    std::array<double, 3 * Vectors> change;
    std::array<Differentiated<3 * Vectors, order>, Strains> strains;
    std::array<double, Strains> stiffness;
  };
  template <int order>
  Stencil<3, 4, 6, order> stencil(const SegmentNodes& segment, std::span<const double> q,
                                  std::span<const double> from) const;
  template <int order>
  Stencil<4, 8, 3, order> stencil(const std::array<SegmentNodes, 2>& vertex, std::span<const double> q,
                                  std::span<const double> from) const;
  /// `previous`: from where q was reached (LocalStage::previous), or nothing.
  template <class Part, std::size_t M>
  void add_hessian_of(const Part& part, const std::array<double, M>& rest, std::span<const double> q,
                      std::span<const double> previous, const BlockWriter& K, Projection projection) const;
  std::size_t number_of(const std::array<SegmentNodes, 2>& vertex) const {
    return static_cast<std::size_t>(vertex_after_[vertex[0].number]);
  }

  PetscInt num_owned_nodes_;
  std::vector<RodSegment> segments_;
  std::vector<RodVertex> vertices_;
  std::vector<Frame> frames_;  // of segments
  /// Strains of vertices at rest, and as the derivatives have them: equal but for rounding, so that both energy and
  /// forces are zero at rest.
  std::vector<std::array<double, 3>> rest_, rest_of_derivatives_;
  std::vector<std::ptrdiff_t> vertex_after_;  // of each segment; -1: none
  Patches patches_;                           // segments
  FixedPairs fixed_;                          // neighbours
  std::vector<std::ptrdiff_t> segment_of_cell_;
  std::vector<Middle> middles_;
};

}  // namespace pliant
