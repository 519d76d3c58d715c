/// A term that Pliant does not have: a trap that pulls every part of a body towards a point, as optical tweezers do.
#pragma once

#include "base/compensated_sum.hpp"
#include "energy/term.hpp"

#include <array>
#include <vector>

/// U = k/2 sum_a V_a |x_a - c|^2, with the nodes' parts V_a of the volume, x_a = X_a + q_a. A quadratic of q:
///
///     dU/dq_a = k V_a (x_a - c),    d2U/dq_a2 = k V_a I
///
/// The centre of mass of a free body of uniform density swings about c with the frequency sqrt(k / density), however
/// the body deforms.
class Trap final : public pliant::EnergyTerm {
 public:
  /// `stiffness` k [N/m^4] per reference volume; the layout and the pattern outlive the term. P1 elements.
  Trap(const pliant::NodeLayout& layout, const pliant::BlockPattern& pattern, double stiffness,
       const std::array<double, 3>& centre)
      : layout_(layout),
        pattern_(pattern),
        weights_(static_cast<std::size_t>(layout.num_owned_nodes)),
        centre_(centre) {
    // A quarter of each tetrahedron for each of its vertices. Cells of other ranks that touch owned nodes are here,
    // too.
    for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
      const auto nodes = layout.nodes_of_cell(cell);
      const double quarter = volume(nodes) / 4.0;
      for (const PetscInt node : nodes) {
        if (node < layout.num_owned_nodes) weights_[static_cast<std::size_t>(node)] += stiffness * quarter;
      }
    }
  }

  std::string_view name() const override { return "trap"; }
  /// An energy of the load's: the ledger books it as load potential.
  pliant::TermDeclaration declaration() const override {
    return {.account = pliant::Account::load_potential, .rotates_with_body = false};
  }

  /// U(q) - U(q0) = sum k V (q - q0) . ((x + x0)/2 - c): no difference of large numbers.
  double value(const pliant::LocalStage& stage, std::span<const double> q) const override {
    return sum([&](std::size_t a, std::size_t i) {
      return (q[3 * a + i] - stage.q0[3 * a + i]) * (arm(a, i) + 0.5 * (q[3 * a + i] + stage.q0[3 * a + i]));
    });
  }
  void add_gradient(const pliant::LocalStage& /*stage*/, std::span<const double> q,
                    std::span<double> r) const override {
    for (std::size_t a = 0; a < weights_.size(); ++a) {
      for (std::size_t i = 0; i < 3; ++i) r[3 * a + i] += weights_[a] * (arm(a, i) + q[3 * a + i]);
    }
  }
  void add_hessian(const pliant::LocalStage& /*stage*/, std::span<const double> /*q*/, const pliant::BlockWriter& K,
                   pliant::Projection /*projection*/) const override {
    for (std::size_t a = 0; a < weights_.size(); ++a) {
      const auto node = static_cast<PetscInt>(a);
      const auto [values, stride] = K.block(node, pattern_.block(node, node));
      for (int i = 0; i < 3; ++i) values[i * stride + i] += weights_[a];
    }
  }
  double energy(std::span<const double> q, std::span<const double> /*z*/) const override {
    return sum([&](std::size_t a, std::size_t i) {
      const double distance = arm(a, i) + q[3 * a + i];
      return 0.5 * distance * distance;
    });
  }

 private:
  double volume(std::span<const PetscInt> nodes) const {
    std::array<std::array<double, 3>, 4> x;
    for (std::size_t a = 0; a < 4; ++a) x[a] = layout_.position(nodes[a]);
    const auto e = [&](std::size_t a, std::size_t i) { return x[a][i] - x[0][i]; };
    return (e(1, 0) * (e(2, 1) * e(3, 2) - e(2, 2) * e(3, 1)) + e(1, 1) * (e(2, 2) * e(3, 0) - e(2, 0) * e(3, 2)) +
            e(1, 2) * (e(2, 0) * e(3, 1) - e(2, 1) * e(3, 0))) /
           6.0;
  }
  /// X - c
  double arm(std::size_t node, std::size_t i) const { return layout_.coordinates[3 * node + i] - centre_[i]; }

  /// Sum of k V_a f(a, i) over owned nodes.
  template <class F>
  double sum(const F& f) const {
    pliant::CompensatedSum<double> total;
    for (std::size_t a = 0; a < weights_.size(); ++a) {
      for (std::size_t i = 0; i < 3; ++i) total.add(weights_[a] * f(a, i));
    }
    return total.total();
  }

  const pliant::NodeLayout& layout_;
  const pliant::BlockPattern& pattern_;
  std::vector<double> weights_;  // k V of owned nodes [N/m]
  std::array<double, 3> centre_;
};
