#include "energy/volume/mass_matrix.hpp"

#include "base/compensated_sum.hpp"
#include "energy/volume/cell_matrix.hpp"

#include <algorithm>
#include <array>

namespace pliant {
namespace {

/// int N_a N_b over cells: one matrix times det J for affine cells, one per batch for curved ones.
template <int Order>
class CellMasses {
 public:
  static constexpr int n = CellGroup<Order>::num_nodes;
  static constexpr int num_pairs = n * (n + 1) / 2;
  static constexpr int index(int a, int b) { return a <= b ? CellMatrix<n>::index(a, b) : CellMatrix<n>::index(b, a); }

  /// The degree of N_a N_b det J: 2 order, plus 3 (order - 1) where the mapping is curved.
  explicit CellMasses(const NodeLayout& layout, const CellGroup<Order>& group) : group_(group) {
    const auto rule = simplex_rule<3>(group.shape == CellShape::affine ? 2 * Order : 5 * Order - 3);
    std::vector<std::array<double, num_pairs>> products(rule.size());
    for (int q = 0; q < rule.size(); ++q) {
      const auto N = Tet<Order>::values(rule.points[q]);
      for (int a = 0; a < n; ++a) {
        for (int b = a; b < n; ++b) products[q][index(a, b)] = rule.weights[q] * N[a] * N[b];
      }
    }
    if (group.shape == CellShape::affine) {
      for (const auto& p : products) {
        for (int k = 0; k < num_pairs; ++k) reference_[k] += p[k];
      }
      return;
    }
    for (const auto& batch : group.batches) {
      auto& mass = curved_.emplace_back();
      for (int q = 0; q < rule.size(); ++q) {
        const Pack jacobian = jacobian_at(layout, batch, Tet<Order>::gradients(rule.points[q]));
        for (int k = 0; k < num_pairs; ++k) mass[k] += products[q][k] * jacobian;
      }
    }
  }

  /// The pair's entry of batch b.
  PLIANT_INLINE Pack operator()(std::size_t b, int pair) const {
    return group_.shape == CellShape::affine ? reference_[pair] * group_.jacobian[b] : curved_[b][pair];
  }

 private:
  static Pack jacobian_at(const NodeLayout& layout, const typename CellGroup<Order>::Batch& batch,
                          const typename CellGroup<Order>::ShapeGradients& dN) {
    const auto x = gather<Order>(batch, layout.coordinates.data());
    Tensor3<Pack> j{};
    for (int a = 1; a < n; ++a) {
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) j(i, k) += (x[a][i] - x[0][i]) * dN[a][k];
      }
    }
    Pack result = det(j);
    for (int lane = batch.num_lanes; lane < pack_size; ++lane) result[lane] = 0.0;
    return result;
  }

  const CellGroup<Order>& group_;
  std::array<double, num_pairs> reference_{};
  std::vector<std::array<Pack, num_pairs>> curved_;
};

/// The consistent mass of every block of the pattern.
template <int Order>
MassMatrix consistent_mass(const NodeLayout& layout, const BlockPattern& pattern, const CellGroups<Order>& groups,
                           const std::vector<double>& densities) {
  constexpr int n = CellGroup<Order>::num_nodes;
  std::vector<double> diagonal(pattern.diagonal().nodes.size(), 0.0);
  std::vector<double> off_diagonal(pattern.off_diagonal().nodes.size(), 0.0);
  for (const auto& group : groups) {
    const CellMasses<Order> masses(layout, group);
    for (std::size_t b = 0; b < group.batches.size(); ++b) {
      const auto& batch = group.batches[b];
      const auto* blocks = group.blocks.data() + b * n * n;
      for (int a = 0; a < n; ++a) {
        for (int c = 0; c < n; ++c) {
          const Pack m = densities[group.body] * masses(b, CellMasses<Order>::index(a, c));
          for (int lane = 0; lane < batch.num_lanes; ++lane) {
            if (batch.nodes[a][lane] >= layout.num_owned_nodes) continue;
            const std::int32_t block = blocks[a * n + c][lane];
            (block >= 0 ? diagonal[block] : off_diagonal[-1 - block]) += m[lane];
          }
        }
      }
    }
  }
  return MassMatrix(layout, pattern, std::move(diagonal), std::move(off_diagonal));
}

/// The given masses on the diagonal of the pattern.
MassMatrix lumped_mass(const NodeLayout& layout, const BlockPattern& pattern, const std::vector<double>& masses) {
  std::vector<double> diagonal(pattern.diagonal().nodes.size(), 0.0);
  for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) diagonal[pattern.block(a, a)] = masses[a];
  return MassMatrix(layout, pattern, std::move(diagonal),
                    std::vector<double>(pattern.off_diagonal().nodes.size(), 0.0));
}

/// The mass that the cells give to each owned node, by each node's share of a cell.
template <int Order, class Share>
std::vector<double> distributed_mass(const NodeLayout& layout, const CellGroups<Order>& groups,
                                     const std::vector<double>& densities, Share share) {
  constexpr int n = CellGroup<Order>::num_nodes;
  std::vector<double> masses(layout.num_local_nodes, 0.0);
  for (const auto& group : groups) {
    const CellMasses<Order> cell_masses(layout, group);
    for (std::size_t b = 0; b < group.batches.size(); ++b) {
      const auto& batch = group.batches[b];
      for (int a = 0; a < n; ++a) {
        const Pack m = densities[group.body] * share(cell_masses, b, a);
        for (int lane = 0; lane < batch.num_lanes; ++lane) masses[batch.nodes[a][lane]] += m[lane];
      }
    }
  }
  std::fill(masses.begin() + layout.num_owned_nodes, masses.end(), 0.0);
  return masses;
}

template <int Order>
Pack row_sum(const CellMasses<Order>& masses, std::size_t b, int a) {
  Pack total = 0.0;
  for (int c = 0; c < CellMasses<Order>::n; ++c) total += masses(b, CellMasses<Order>::index(a, c));
  return total;
}

template <int Order>
Pack lumped_share(const CellMasses<Order>& masses, std::size_t b, int a) {
  Pack total = 0.0, diagonal = 0.0;
  for (int c = 0; c < CellMasses<Order>::n; ++c) {
    total += row_sum(masses, b, c);
    diagonal += masses(b, CellMasses<Order>::index(c, c));
  }
  const Pack share = masses(b, CellMasses<Order>::index(a, a)) * total;
  return share / select(diagonal > 0.0, diagonal, Pack(1.0));  // padding lanes: 0 / 1
}

}  // namespace

MassMatrix::MassMatrix(const NodeLayout& layout, const BlockPattern& pattern, std::vector<double> diagonal,
                       std::vector<double> off_diagonal)
    : num_owned_nodes_(layout.num_owned_nodes),
      num_local_nodes_(layout.num_local_nodes),
      diagonal_{&pattern.diagonal(), std::move(diagonal)},
      off_diagonal_{&pattern.off_diagonal(), std::move(off_diagonal)} {}

void MassMatrix::add_times(std::span<const double> x, std::span<double> y) const {
  for (const Part* part : {&diagonal_, &off_diagonal_}) {
    const auto& [offsets, nodes] = *part->rows;
    for (PetscInt a = 0; a < num_owned_nodes_; ++a) {
      std::array<double, 3> total{};
      for (PetscInt k = offsets[a]; k < offsets[a + 1]; ++k) {
        const double* column = x.data() + 3 * nodes[k];
        for (int i = 0; i < 3; ++i) total[i] += part->masses[k] * column[i];
      }
      for (int i = 0; i < 3; ++i) y[3 * a + i] += total[i];
    }
  }
}

void MassMatrix::add_to(double factor, const BlockWriter& K) const {
  for (const Part* part : {&diagonal_, &off_diagonal_}) {
    for (PetscInt a = 0; a < num_owned_nodes_; ++a) {
      for (PetscInt k = part->rows->offsets[a]; k < part->rows->offsets[a + 1]; ++k) {
        const auto [values, stride] = K.block(a, part == &diagonal_ ? k : -1 - k);
        for (int i = 0; i < 3; ++i) values[i * stride + i] += factor * part->masses[k];
      }
    }
  }
}

void MassMatrix::assign_to(double factor, const BlockWriter& K) const {
  for (const Part* part : {&diagonal_, &off_diagonal_}) {
    for (PetscInt a = 0; a < num_owned_nodes_; ++a) {
      const PetscInt begin = part->rows->offsets[a], end = part->rows->offsets[a + 1];
      if (begin == end) continue;
      double* values = K.block(a, part == &diagonal_ ? begin : -1 - begin).values;
      for (int i = 0; i < 3; ++i) {
        for (PetscInt k = begin; k < end; ++k) {
          for (int j = 0; j < 3; ++j) *values++ = i == j ? factor * part->masses[k] : 0.0;
        }
      }
    }
  }
}

void MassMatrix::put_diagonal(std::span<double> diagonal) const {
  const auto& [offsets, nodes] = *diagonal_.rows;
  for (PetscInt a = 0; a < num_owned_nodes_; ++a) {
    for (PetscInt k = offsets[a]; k < offsets[a + 1]; ++k) {
      if (nodes[k] != a) continue;
      for (int i = 0; i < 3; ++i) diagonal[3 * a + i] = diagonal_.masses[k];
    }
  }
}

double MassMatrix::product(std::span<const double> x, std::span<const double> y) const {
  std::vector<double> My(y.size(), 0.0);
  add_times(y, My);
  CompensatedSum<double> total;
  for (PetscInt i = 0; i < 3 * num_owned_nodes_; ++i) total.add(x[i] * My[i]);
  return total.total();
}

void MassMatrix::add(std::int32_t block, double mass) {
  (block >= 0 ? diagonal_.masses[static_cast<std::size_t>(block)]
              : off_diagonal_.masses[static_cast<std::size_t>(-1 - block)]) += mass;
}

double MassMatrix::total() const {
  const std::vector<double> one(static_cast<std::size_t>(3 * num_local_nodes_), 1.0);
  std::vector<double> y(one.size(), 0.0);
  add_times(one, y);
  CompensatedSum<double> total;
  for (PetscInt a = 0; a < num_owned_nodes_; ++a) total.add(y[3 * a]);
  return total.total();
}

template <int Order>
MassMatrix make_mass_matrix(const NodeLayout& layout, const BlockPattern& pattern, const CellGroups<Order>& groups,
                            const std::vector<double>& densities, Mass mass) {
  if (mass == Mass::consistent) return consistent_mass(layout, pattern, groups, densities);
  return lumped_mass(layout, pattern, distributed_mass(layout, groups, densities, lumped_share<Order>));
}

template <int Order>
CellMassProducts make_cell_mass_products(const NodeLayout& layout, const CellGroups<Order>& groups,
                                         std::vector<double> densities, Mass mass) {
  constexpr int n = CellGroup<Order>::num_nodes;
  return [&layout, &groups, densities = std::move(densities), mass](
             std::span<const double> x, std::span<const double> y, std::span<double> works) {
    for (const auto& group : groups) {
      const CellMasses<Order> masses(layout, group);
      for (std::size_t b = 0; b < group.batches.size(); ++b) {
        const auto& batch = group.batches[b];
        const auto of_x = gather<Order>(batch, x.data()), of_y = gather<Order>(batch, y.data());
        Pack work = 0.0;
        for (int a = 0; a < n; ++a) {
          for (int c = 0; c < n; ++c) {
            if (mass == Mass::lumped && c != a) continue;
            const Pack m =
                mass == Mass::lumped ? lumped_share(masses, b, a) : masses(b, CellMasses<Order>::index(a, c));
            work += m * (of_x[a][0] * of_y[c][0] + of_x[a][1] * of_y[c][1] + of_x[a][2] * of_y[c][2]);
          }
        }
        work *= densities[static_cast<std::size_t>(group.body)];
        for (int lane = 0; lane < batch.num_lanes; ++lane) {
          works[static_cast<std::size_t>(group.cells[b * pack_size + static_cast<std::size_t>(lane)])] += work[lane];
        }
      }
    }
  };
}

template <int Order>
std::vector<double> nodal_masses(const NodeLayout& layout, const CellGroups<Order>& groups,
                                 const std::vector<double>& densities) {
  return distributed_mass(layout, groups, densities, row_sum<Order>);
}

template MassMatrix make_mass_matrix<1>(const NodeLayout&, const BlockPattern&, const CellGroups<1>&,
                                        const std::vector<double>&, Mass);
template MassMatrix make_mass_matrix<2>(const NodeLayout&, const BlockPattern&, const CellGroups<2>&,
                                        const std::vector<double>&, Mass);
template CellMassProducts make_cell_mass_products<1>(const NodeLayout&, const CellGroups<1>&, std::vector<double>,
                                                     Mass);
template CellMassProducts make_cell_mass_products<2>(const NodeLayout&, const CellGroups<2>&, std::vector<double>,
                                                     Mass);
template std::vector<double> nodal_masses<1>(const NodeLayout&, const CellGroups<1>&, const std::vector<double>&);
template std::vector<double> nodal_masses<2>(const NodeLayout&, const CellGroups<2>&, const std::vector<double>&);

}  // namespace pliant
