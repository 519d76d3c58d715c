/// Springs between the nodes of two bodies that are near each other: a term of pairs whose set changes as they move.
#pragma once

#include "energy/solid.hpp"

#include <cmath>

namespace pliant::test {

/// U = k (L - d)^3 / (3 L) for each pair of nodes of two bodies at the distance d < L [J]; the bodies lie on either
/// side of the plane x = `between`.
class NearSprings final : public EnergyTerm, public PairCoupling {
 public:
  NearSprings(const NodeLayout& layout, double between, double stiffness, double length)
      : stiffness_(stiffness), length_(length) {
    for (PetscInt node = 0; node < layout.num_owned_nodes; ++node) {
      patches_.nodes.push_back(node);
      patches_.keys.push_back(layout.global_node(node));
      patches_.tags.push_back(layout.position(node)[0] < between ? 0 : 1);
      patches_.is_owned.push_back(1);
    }
  }

  const Patches& patches() const override { return patches_; }
  double reach() const override { return length_; }
  bool may_couple(int tag, int other) const override { return tag != other; }

  std::string_view name() const override { return "springs between near nodes"; }
  TermDeclaration declaration() const override { return {}; }
  Coupling coupling() const override { return static_cast<const PairCoupling*>(this); }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    double sum = 0.0;
    for_each_spring(*stage.near, q, [&](const PatchPair& pair, PetscInt, PetscInt, const Vector3<double>&, double d) {
      if (stage.near->patches.is_owned[pair.first]) sum += stiffness_ * std::pow(length_ - d, 3) / (3.0 * length_);
    });
    return sum;
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    for_each_spring(*stage.near, q, [&](const PatchPair&, PetscInt a, PetscInt b, const Vector3<double>& n, double d) {
      const double force = slope(d);
      for (PetscInt i = 0; i < 3; ++i) {
        r[3 * a + i] -= force * n[static_cast<std::size_t>(i)];
        r[3 * b + i] += force * n[static_cast<std::size_t>(i)];
      }
    });
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    for_each_spring(*stage.near, q, [&](const PatchPair&, PetscInt a, PetscInt b, const Vector3<double>& n, double d) {
      const double along = 2.0 * stiffness_ * (length_ - d) / length_;
      const double across = projection == Projection::none ? slope(d) / d : 0.0;
      std::array<double, 9> same{}, other{};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          same[3 * i + j] = along * n[i] * n[j] + across * ((i == j ? 1.0 : 0.0) - n[i] * n[j]);
          other[3 * i + j] = -same[3 * i + j];
        }
      }
      K.add(a, a, same);
      K.add(b, b, same);
      K.add(a, b, other);
      K.add(b, a, other);
    });
  }

  double energy_at(const Instant& at, std::span<const double> q, std::span<const double>) const override {
    LocalStage stage;
    stage.near = at.near;
    return value(stage, q);
  }

 private:
  /// dU/dd.
  double slope(double d) const { return -stiffness_ * std::pow(length_ - d, 2) / length_; }

  /// Calls `visit(pair, a, b, n, d)`: n points from node a to node b, which are d < L apart.
  template <class Visit>
  void for_each_spring(const NearPatches& near, std::span<const double> q, const Visit& visit) const {
    for (const PatchPair& pair : near.pairs) {
      const PetscInt a = near.patches.nodes_of(pair.first)[0], b = near.patches.nodes_of(pair.second)[0];
      const Vector3<double> way = near.position(b, q) - near.position(a, q);
      const double d = std::sqrt(pliant::dot(way, way));
      if (d < length_) visit(pair, a, b, (1.0 / d) * way, d);
    }
  }

  Patches patches_;
  double stiffness_, length_;
};

/// Writes two unit cubes, `gap` apart along x, with so many cells' cubes along each edge.
inline void write_two_cubes(const std::string& file, double gap, int cubes = 2) {
  BoxOptions options;
  options.missing = cubes;
  const double side = 1.0 / cubes;
  options.map = [=](std::array<double, 3> x) {
    if (x[0] > 1.0 + 0.5 * side) x[0] += gap - side;
    return x;
  };
  write_box_msh(file, {2.0 + side, 1.0, 1.0}, {2 * cubes + 1, cubes, cubes}, options);
}

}  // namespace pliant::test
