#include "energy/shell/hinge_sums.hpp"

#include <algorithm>

namespace pliant {
std::vector<OfHingeNodes> slopes_of_angles(const BendingStencils& seen, std::span<const double> q) {
  std::vector<OfHingeNodes> result;
  result.reserve(seen.hinges.size());
  for (const BendingHinge& hinge : seen.hinges) {
    const auto angle = differentiated_angle<1>(hinge.at(q));
    const HingeMap map = hinge.map();
    OfHingeNodes& slopes = result.emplace_back();
    for (std::size_t row = 0; row < 9; ++row) {
      for (std::size_t k = 0; k < 12; ++k) slopes[k] += map[12 * row + k] * angle.slope[row];
    }
  }
  return result;
}

OfHingeNodes bend_along(const BendingHinge& hinge, std::span<const double> q, std::span<const double> d) {
  const auto angle = differentiated_angle<2>(hinge.at(q));
  const HingeVectors change = hinge.vectors(d);
  const HingeMap map = hinge.map();
  OfHingeNodes result{};
  for (std::size_t p = 0; p < 9; ++p) {
    double product = 0.0;
    for (std::size_t s = 0; s < 9; ++s) product += angle.bend_of(p, s) * change[s / 3][s % 3];
    for (std::size_t k = 0; k < 12; ++k) result[k] += map[12 * p + k] * product;
  }
  return result;
}

double sum_over_nodes(const BendingHinge& hinge, const OfHingeNodes& slopes, std::span<const double> d) {
  // Common displacements cancel before they are multiplied.
  const auto first = 3 * static_cast<std::size_t>(hinge.nodes[0]);
  double sum = 0.0;
  for (std::size_t a = 1; a < 4; ++a) {
    if (hinge.nodes[a] < 0) continue;
    const auto node = 3 * static_cast<std::size_t>(hinge.nodes[a]);
    for (std::size_t i = 0; i < 3; ++i) sum += slopes[3 * a + i] * (d[node + i] - d[first + i]);
  }
  return sum;
}

void add_moments(const BendingStencils& seen, std::span<const double> moments, std::span<const OfHingeNodes> slopes,
                 PetscInt num_owned_nodes, std::span<double> r) {
  for (std::size_t h = 0; h < seen.hinges.size(); ++h) {
    for (std::size_t a = 0; a < 4; ++a) {
      const PetscInt node = seen.hinges[h].nodes[a];
      if (node < 0 || node >= num_owned_nodes) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        r[3 * static_cast<std::size_t>(node) + i] += moments[h] * slopes[h][3 * a + i];
      }
    }
  }
}

void add_products(const BendingStencil& stencil, std::span<const double> M, std::span<const OfHingeNodes> left,
                  std::span<const OfHingeNodes> right, PetscInt num_owned_nodes, const BlockWriter& K) {
  constexpr std::size_t most_hinges = BendingStencil::most_hinges, width = 3 * BendingStencil::most_nodes;
  const std::size_t n = stencil.num_hinges;
  std::array<double, most_hinges * width> W{}, R{}, MR{};  // of the hinges, by all nodes of the stencil
  for (std::size_t h = 0; h < n; ++h) {
    for (std::size_t k = 0; k < 12; ++k) {
      const auto place = stencil.places[h][k / 3];
      if (place < 0) continue;
      const std::size_t at = width * h + 3 * static_cast<std::size_t>(place) + k % 3;
      W[at] += left[stencil.hinges[h]][k];
      R[at] += right[stencil.hinges[h]][k];
    }
  }
  for (std::size_t h = 0; h < n; ++h) {
    for (std::size_t g = 0; g < n; ++g) {
      for (std::size_t k = 0; k < width; ++k) MR[width * h + k] += M[most_hinges * h + g] * R[width * g + k];
    }
  }
  for (std::size_t a = 0; a < stencil.num_nodes; ++a) {
    if (stencil.nodes[a] >= num_owned_nodes) continue;
    for (std::size_t b = 0; b < stencil.num_nodes; ++b) {
      std::array<double, 9> block{};
      for (std::size_t h = 0; h < n; ++h) {
        for (std::size_t i = 0; i < 9; ++i) block[i] += W[width * h + 3 * a + i / 3] * MR[width * h + 3 * b + i % 3];
      }
      K.add(stencil.nodes[a], stencil.nodes[b], block);
    }
  }
}

void add_bend(const BendingHinge& hinge, double moment, std::span<const double> q, PetscInt num_owned_nodes,
              const BlockWriter& K) {
  if (moment == 0.0) return;
  if (std::ranges::none_of(hinge.nodes, [&](PetscInt n) { return n >= 0 && n < num_owned_nodes; })) return;
  const auto angle = differentiated_angle<2>(hinge.at(q));
  const HingeMap map = hinge.map();
  std::array<double, 108> BJ{};  // 9 x 12
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t s = 0; s < 9; ++s) {
      const double entry = moment * angle.bend_of(p, s);
      for (std::size_t k = 0; k < 12; ++k) BJ[12 * p + k] += entry * map[12 * s + k];
    }
  }
  for (std::size_t a = 0; a < 4; ++a) {
    if (hinge.nodes[a] < 0 || hinge.nodes[a] >= num_owned_nodes) continue;
    for (std::size_t b = 0; b < 4; ++b) {
      if (hinge.nodes[b] < 0) continue;
      std::array<double, 9> block{};
      for (std::size_t p = 0; p < 9; ++p) {
        for (std::size_t i = 0; i < 9; ++i) block[i] += map[12 * p + 3 * a + i / 3] * BJ[12 * p + 3 * b + i % 3];
      }
      K.add(hinge.nodes[a], hinge.nodes[b], block);
    }
  }
}

}  // namespace pliant
