/// Two places of surfaces that touch, as the terms of friction and damping see them.
#pragma once

#include "base/vector3.hpp"

#include <algorithm>
#include <array>
#include <span>

#include <petscsys.h>

namespace pliant {

/// A point of one surface and the nearest one of another: r = sum w_i x_i between them, with the nodes' positions x_i.
struct Touch {
  std::array<PetscInt, 12> nodes{};  ///< local; those of the first surface come first
  std::array<double, 12> weights{};  ///< w_i, whose sum is 0
  int num_nodes = 0, num_first_nodes = 0;
  double pressure = 0.0;     ///< [Pa], > 0
  double area = 0.0;         ///< [m^2]; negative where a feature is subtracted (collision/contact_pairs)
  Vector3<double> normal{};  ///< of the second surface, towards the first
  bool is_counted = false;   ///< by this rank, among all that have it

  /// Adds a node with its weight, or the weight to that of the node if it is there from `begin` on.
  void add(PetscInt node, double weight, int begin) {
    const auto end = nodes.begin() + num_nodes;
    const auto known = std::find(nodes.begin() + begin, end, node);
    if (known == end) nodes[static_cast<std::size_t>(num_nodes++)] = node;
    weights[static_cast<std::size_t>(known - nodes.begin())] += weight;
  }
  /// sum w_i (to_i - from_i) of two configurations.
  Vector3<double> displacement(std::span<const double> from, std::span<const double> to) const {
    return sum([&](std::size_t entry) { return to[entry] - from[entry]; });
  }
  /// sum w_i v_i of a nodal field.
  Vector3<double> combine(std::span<const double> v) const {
    return sum([&](std::size_t entry) { return v[entry]; });
  }

 private:
  Vector3<double> sum(const auto& value_of) const {
    Vector3<double> total{};
    for (int i = 0; i < num_nodes; ++i) {
      const auto n = 3 * static_cast<std::size_t>(nodes[i]);
      for (std::size_t k = 0; k < 3; ++k) total[k] += weights[i] * value_of(n + k);
    }
    return total;
  }
};

}  // namespace pliant
