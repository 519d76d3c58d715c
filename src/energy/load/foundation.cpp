#include "energy/load/foundation.hpp"

#include "base/compensated_sum.hpp"
#include "base/vector3.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// dA [m^2 per reference area] times D at a point of a facet.
template <int Order>
Tensor3<double> weighted_projector(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                   const std::array<double, 2>& xi, FoundationDirection direction) {
  const auto dN = Triangle<Order>::gradients(xi);
  Vector3<double> X_xi{}, X_eta{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const Vector3<double> X = layout.position(nodes[a]);
    X_xi = X_xi + dN[a][0] * X;
    X_eta = X_eta + dN[a][1] * X;
  }
  const Vector3<double> n = cross(X_xi, X_eta);
  const double area = std::sqrt(dot(n, n));
  Tensor3<double> D{};
  for (int i = 0; i < 3; ++i) {
    if (direction == FoundationDirection::all) D(i, i) = area;
    for (int j = 0; j < 3 && direction == FoundationDirection::normal; ++j) D(i, j) = n[i] * n[j] / area;
  }
  return D;
}

/// One block per pair of nodes.
FoundationMatrix merged(std::vector<FoundationMatrix::Block> blocks) {
  const auto place = [](const FoundationMatrix::Block& b) { return std::pair(b.row, b.column); };
  std::ranges::stable_sort(blocks, {}, place);
  FoundationMatrix matrix;
  for (const auto& b : blocks) {
    if (matrix.blocks.empty() || place(matrix.blocks.back()) != place(b)) {
      matrix.blocks.push_back(b);
    } else {
      matrix.blocks.back().value = matrix.blocks.back().value + b.value;
    }
  }
  return matrix;
}

template <int Order>
FoundationMatrix surface_foundation_of(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                                       FoundationDirection direction) {
  constexpr int n = Triangle<Order>::num_nodes;
  // N_a N_b, and the mapping of curved facets.
  const auto rule = simplex_rule<2>(2 * Order + 2 * (Order - 1));
  std::vector<FoundationMatrix::Block> blocks;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = std::span(facets.nodes).subspan(f * n, n);
    std::array<Tensor3<double>, n * n> of_facet{};
    for (int p = 0; p < rule.size(); ++p) {
      const auto N = Triangle<Order>::values(rule.points[p]);
      const auto D = weighted_projector<Order>(layout, nodes, rule.points[p], direction);
      for (int a = 0; a < n; ++a) {
        for (int b = 0; b < n; ++b) of_facet[a * n + b] = of_facet[a * n + b] + rule.weights[p] * N[a] * N[b] * D;
      }
    }
    for (int a = 0; a < n; ++a) {
      if (nodes[a] >= layout.num_owned_nodes) continue;
      for (int b = 0; b < n; ++b) {
        blocks.push_back({nodes[a], nodes[b], pattern.block(nodes[a], nodes[b]), of_facet[a * n + b]});
      }
    }
  }
  return merged(std::move(blocks));
}

/// x . M y over the owned rows, with x and y as functions of the entry.
template <class X, class Y>
double product(const FoundationMatrix& matrix, X x, Y y) {
  CompensatedSum<double> total;
  for (const auto& [row, column, number, M] : matrix.blocks) {
    for (int i = 0; i < 3; ++i) {
      double My = 0.0;
      for (int j = 0; j < 3; ++j) My += M(i, j) * y(3 * column + j);
      total.add(x(3 * row + i) * My);
    }
  }
  return total.total();
}

}  // namespace

FoundationMatrix surface_foundation(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                                    FoundationDirection direction) {
  return layout.order == 1 ? surface_foundation_of<1>(layout, pattern, facets, direction)
                           : surface_foundation_of<2>(layout, pattern, facets, direction);
}

FoundationMatrix nodal_foundation(const BlockPattern& pattern, const std::vector<PetscInt>& nodes, double weight) {
  Tensor3<double> M{};
  for (int i = 0; i < 3; ++i) M(i, i) = weight;
  FoundationMatrix matrix;
  for (const PetscInt node : nodes) matrix.blocks.push_back({node, node, pattern.block(node, node), M});
  return matrix;
}

double Foundation::value(const LocalStage& stage, std::span<const double> q) const {
  // k/2 (|q|^2 - |q0|^2) = d . M k (q + q0)/2,  dt c/2 |d/dt|^2 = d . M c/(2 dt) d,  d = q - q0
  const double k = 0.5 * stiffness_.spring, c = 0.5 * stiffness_.dashpot / stage.dt;
  const auto d = [&](PetscInt i) { return q[i] - stage.q0[i]; };
  return product(matrix_, d, [&](PetscInt i) { return k * (q[i] + stage.q0[i]) + c * d(i); });
}

void Foundation::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const double k = stiffness_.spring, c = stiffness_.dashpot / stage.dt;
  for (const auto& [row, column, number, M] : matrix_.blocks) {
    for (int j = 0; j < 3; ++j) {
      const PetscInt e = 3 * column + j;
      const double pull = k * q[e] + c * (q[e] - stage.q0[e]);
      for (int i = 0; i < 3; ++i) r[3 * row + i] += M(i, j) * pull;
    }
  }
}

void Foundation::add_hessian(const LocalStage& stage, std::span<const double>, const BlockWriter& K, Projection) const {
  const double factor = stiffness_.spring + stiffness_.dashpot / stage.dt;
  for (const auto& [row, column, number, M] : matrix_.blocks) {
    const auto [values, stride] = K.block(row, number);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) values[i * stride + j] += factor * M(i, j);
    }
  }
}

void Foundation::pull_back(const LocalStage& stage, std::span<const double> /*q*/, const StageMultipliers& m,
                           const StageSlopes& slopes) const {
  const double c = stiffness_.dashpot / stage.dt;
  for (const auto& [row, column, number, M] : matrix_.blocks) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) slopes.q0[3 * row + i] -= c * M(i, j) * m.residual[3 * column + j];
    }
  }
}

double Foundation::energy(std::span<const double> q, std::span<const double> /*z*/) const {
  const auto u = [&](PetscInt i) { return q[i]; };
  return 0.5 * stiffness_.spring * product(matrix_, u, u);
}

double Foundation::dissipation(const LocalStage& stage, std::span<const double> q) const {
  const auto v = [&](PetscInt i) { return (q[i] - stage.q0[i]) / stage.dt; };
  return stiffness_.dashpot * product(matrix_, v, v);
}

}  // namespace pliant
