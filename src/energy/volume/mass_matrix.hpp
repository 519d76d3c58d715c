/// The mass matrix M of the bodies, or of any other density given per body.
#pragma once

#include "fem/block_matrix.hpp"
#include "fem/cells.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace pliant {

enum class Mass { consistent, lumped };

/// One scalar per pair of nodes that share a cell, assembled once; it acts on each component alike. No method is
/// collective; arrays span all local nodes.
class MassMatrix {
 public:
  /// `diagonal`, `off_diagonal`: masses of the pattern's blocks of owned and of other columns [kg]. The pattern
  /// outlives the object.
  MassMatrix(const NodeLayout& layout, const BlockPattern& pattern, std::vector<double> diagonal,
             std::vector<double> off_diagonal);

  /// y += M x on rows of owned nodes [x unit * kg].
  void add_times(std::span<const double> x, std::span<double> y) const;
  /// x . M y over the owned nodes' rows, summed with compensation.
  double product(std::span<const double> x, std::span<const double> y) const;
  /// K += factor M, rows of owned nodes.
  void add_to(double factor, const BlockWriter& K) const;
  /// K = factor M, likewise; K is overwritten.
  void assign_to(double factor, const BlockWriter& K) const;
  /// diagonal = that of M, of owned nodes [kg].
  void put_diagonal(std::span<double> diagonal) const;
  /// This rank's share of the mass [kg].
  double total() const;
  /// Adds a mass to a block of the pattern (BlockPattern::block) [kg].
  void add(std::int32_t block, double mass);

 private:
  struct Part {
    const BlockPattern::Rows* rows;
    std::vector<double> masses;  // per block [kg]
  };
  PetscInt num_owned_nodes_;
  PetscInt num_local_nodes_;
  Part diagonal_;
  Part off_diagonal_;
};

/// `densities`: per body [kg/m^3]. The consistent mass is integrated exactly on affine cells, on curved ones to the
/// degree of their mapping; the lumped mass distributes each cell's mass in proportion to the diagonal of its
/// consistent matrix (Hinton, Rock & Zienkiewicz 1976), so that it stays positive for P2. `pattern` outlives it.
template <int Order>
MassMatrix make_mass_matrix(const NodeLayout& layout, const BlockPattern& pattern, const CellGroups<Order>& groups,
                            const std::vector<double>& densities, Mass mass);

/// works[c] += x . M_c y of each local cell c, with the mass matrix M_c of the cell alone [x unit * y unit * kg]. The
/// arrays span all local nodes. Not collective.
using CellMassProducts =
    std::function<void(std::span<const double> x, std::span<const double> y, std::span<double> works)>;
/// Products with the masses that make_mass_matrix sums. `layout` and `groups` outlive the result.
template <int Order>
CellMassProducts make_cell_mass_products(const NodeLayout& layout, const CellGroups<Order>& groups,
                                         std::vector<double> densities, Mass mass);

/// int density N_a dX per owned node [kg], 0 in ghost places. Not collective.
template <int Order>
std::vector<double> nodal_masses(const NodeLayout& layout, const CellGroups<Order>& groups,
                                 const std::vector<double>& densities);

}  // namespace pliant
