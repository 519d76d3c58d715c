/// What terms are held against: dense eigenvalues, and forces in four times the digits.
#pragma once

#include "energy/solid.hpp"
#include "material/states.hpp"

namespace pliant::test {

using testing_states::Quad;

/// The smallest and the largest eigenvalue of the Hessian at q.
std::array<double, 2> extreme_eigenvalues(IncrementalPotential& potential, Vec q, Projection projection);

using Gradients = std::vector<Tensor3<Quad>>;

/// Internal forces at the local nodes, cell by cell, from a stress P that is a function of the gradients of `fields`.
template <int Order, class Stress>
std::vector<Quad> reference_forces(const Solid& solid, int degree, const std::vector<std::vector<double>>& fields,
                                   Stress P) {
  const NodeLayout& layout = solid.layout();
  const auto rule = simplex_rule<3>(degree);
  std::vector<Quad> r(layout.coordinates.size(), Quad(0));
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    for (const auto& xi : rule.points) {
      const auto dN = Tet<Order>::gradients(xi);
      const auto gradient = [&](const std::vector<double>& values) {
        Tensor3<Quad> G{};
        for (std::size_t a = 0; a < nodes.size(); ++a) {
          for (int i = 0; i < 3; ++i) {
            for (int k = 0; k < 3; ++k) G(i, k) += Quad(values[3 * nodes[a] + i]) * dN[a][k];
          }
        }
        return G;
      };
      const Tensor3<Quad> X = gradient(layout.coordinates);
      const Quad J = det(X), weight = rule.weights[static_cast<std::size_t>(&xi - rule.points.data())];
      const Tensor3<Quad> inverse = Quad(1 / J) * transpose(cofactor(X));
      Gradients H;
      for (const auto& field : fields) H.push_back(matmul(gradient(field), inverse));
      const Tensor3<Quad> S = Quad(J * weight) * matmul(P(H), transpose(inverse));
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        for (int i = 0; i < 3; ++i) {
          for (int k = 0; k < 3; ++k) r[3 * nodes[a] + i] += S(i, k) * dN[a][k];
        }
      }
    }
  }
  return r;
}

/// |r - expected| and |expected| over the owned nodes of all ranks. Collective.
template <class Stress>
std::array<double, 2> error_and_size(const Solid& solid, int degree, const std::vector<double>& r,
                                     const std::vector<std::vector<double>>& fields, Stress P) {
  const auto expected = solid.layout().order == 1 ? reference_forces<1>(solid, degree, fields, P)
                                                  : reference_forces<2>(solid, degree, fields, P);
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(solid.layout().num_owned_nodes); ++i) {
    error += std::pow(static_cast<double>(Quad(r[i]) - expected[i]), 2);
    size += std::pow(static_cast<double>(expected[i]), 2);
  }
  return {std::sqrt(sum(solid.layout().comm, error)), std::sqrt(sum(solid.layout().comm, size))};
}

}  // namespace pliant::test
