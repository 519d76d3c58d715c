/// Rods that resist nothing but a change of their length: fibres in bodies, along edges of cells.
#pragma once

#include "base/vector3.hpp"
#include "energy/rod/fibre_segment.hpp"
#include "energy/term.hpp"
#include "energy/volume/affine_bodies.hpp"
#include "energy/volume/mass_matrix.hpp"
#include "fem/layout.hpp"

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace pliant {

/// All fibres of a model. With t = dx/ds of a segment of the length l, which is the edge of a cell of a body, their
/// energy is
///
///     U = sum l/2 E A (|t| - 1)^2.
///
/// They have no nodes of their own, and couple none that cells do not. U depends on positions alone, and does not
/// change in rigid motions: every method keeps its order, and momenta are conserved.
class Fibres final : public EnergyTerm {
 public:
  /// `segments`: the same on every rank, edges of cells of the layout. Collective. Throws std::logic_error if an end of
  /// one is not a corner of a cell.
  Fibres(const NodeLayout& layout, std::span<const FibreSegment> segments);

  std::string_view name() const override { return "rods"; }
  TermDeclaration declaration() const override { return {}; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double energy(std::span<const double> q, std::span<const double> z) const override;

  /// Adds their mass, uniform over the length or in halves at its ends (`mass_kind`). Not collective.
  void add_masses(const BlockPattern& pattern, Mass mass_kind, MassMatrix& mass) const;
  /// What uniform accelerations act on, of this rank's nodes; `of_segments`: one flag per segment. Not collective.
  std::vector<MassAtNode> masses(std::span<const char> of_segments) const;

  /// Segments with a node of this rank, by their numbers.
  const std::vector<LocalFibre>& segments_here() const { return segments_; }
  /// E A (|t| - 1) of one of them at displacements q of the local nodes [N].
  static double tension(const LocalFibre& of, std::span<const double> q);

 private:
  PetscInt num_owned_nodes_;
  std::vector<LocalFibre> segments_;
};

/// Resists the rate of the stretch of fibres as RodViscosity does that of rods.
class FibreViscosity final : public EnergyTerm {
 public:
  /// `fibres` outlives the object. `layout`: that of the fibres.
  FibreViscosity(const NodeLayout& layout, const Fibres& fibres)
      : num_owned_nodes_(layout.num_owned_nodes), fibres_(fibres) {}

  std::string_view name() const override { return "rod-viscosity"; }
  TermDeclaration declaration() const override { return viscous_force; }
  double value(const LocalStage& /*stage*/, std::span<const double> /*q*/) const override { return 0.0; }
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override;
  double dissipation(const LocalStage& stage, std::span<const double> q) const override;

 private:
  PetscInt num_owned_nodes_;
  const Fibres& fibres_;
};

}  // namespace pliant
