/// Dead loads (Neumann boundary conditions and body forces): forces per reference volume, area or length, or at nodes,
/// that depend on place and time but not on the motion; U = -int f . u.
#pragma once

#include "base/expression.hpp"
#include "energy/term.hpp"
#include "fem/layout.hpp"
#include "fem/selection.hpp"

#include <array>
#include <vector>

namespace pliant {

/// Points at which a load's density is evaluated, and its distribution to the nodes.
struct LoadSamples {
  int nodes_per_item = 0;
  int points_per_item = 0;
  std::vector<PetscInt> nodes;                ///< local nodes per item (cell, facet, edge or node)
  std::vector<PetscInt> cells;                ///< the local cell of each item; empty for other items
  std::vector<std::vector<double>> shapes;    ///< N_a at the points of an item
  std::vector<std::array<double, 3>> points;  ///< reference positions, points_per_item per item [m]
  std::vector<double> weights;                ///< likewise: measure [m, m^2 or m^3], times the factor of the item
};

enum class Variation { uniform, in_space };

/// Samples of cells, each weighted by `factor_of_cell` (e.g. a density); a factor of zero leaves the cell out.
LoadSamples cell_samples(const NodeLayout& layout, const std::vector<double>& factor_of_cell, Variation variation);

/// Likewise for bodies of lumped mass: at the nodes, each weighted by its share of the cell's mass, as in the lumped
/// inertia, so that a body falls without vibrating.
LoadSamples lumped_cell_samples(const NodeLayout& layout, const std::vector<double>& factor_of_cell);

/// Samples of facets and of edges.
LoadSamples facet_samples(const NodeLayout& layout, const FacetList& facets, Variation variation);
LoadSamples edge_samples(const NodeLayout& layout, const EdgeList& edges, Variation variation);

/// One sample of weight 1 per owned node.
LoadSamples node_samples(const NodeLayout& layout, const std::vector<PetscInt>& nodes);

/// The samples with their weights divided by the total weight of the owned items on all ranks, which makes a density a
/// total force. `is_owned`: one flag per item. Collective.
LoadSamples with_total_weight_one(const NodeLayout& layout, LoadSamples samples, const std::vector<char>& is_owned);

/// Whether a load with these components varies in space.
Variation variation_of(const std::array<Expression, 3>& value);

class DeadLoad final : public EnergyTerm {
 public:
  /// `value` [N per unit of the samples' weights], a function of X and t. The layout outlives the object.
  DeadLoad(const NodeLayout& layout, LoadSamples samples, std::array<Expression, 3> value);

  std::string_view name() const override { return "load"; }
  TermDeclaration declaration() const override {
    return {.account = depends_on_time() ? Account::load : Account::load_potential, .has_load_energy = true};
  }
  bool has_adjoint() const override { return true; }
  double value(const LocalStage& stage, std::span<const double> q) const override;
  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override;
  void add_hessian(const LocalStage&, std::span<const double>, const BlockWriter&, Projection) const override {}

  /// Works of a load on cells that is uniform in space; other loads add nothing.
  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override;
  /// -int f . u.
  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override;

  /// Nodal forces at a time, rows of owned nodes [N].
  std::vector<double> forces(double time) const;
  bool depends_on_time() const;

 private:
  /// Calls `add(owned entry, force)`, possibly several times per entry.
  template <class Add>
  void for_each_force(double time, Add add) const;
  template <class Add>
  void for_each_sample(double time, Add add) const;
  std::vector<double> sampled(double time) const;

  double weight_in_cell(std::size_t item, std::size_t node) const;

  const NodeLayout& layout_;
  PetscInt num_owned_nodes_;
  std::size_t size_;
  std::array<Expression, 3> value_;
  LoadSamples samples_;                // if the load varies in space, and in time or by replacement
  std::vector<double> nodal_weights_;  // if it is uniform in space; then samples_ has the cells, and their samples or
  std::vector<double> cell_weights_;   // instead, if they are fewer, the weights of the nodes of each cell
  std::vector<double> constant_;       // if it varies in space alone
};

}  // namespace pliant
