/// A joint coordinate as an unknown: the least that a class of dependent nodes needs.
#pragma once

#include "energy/constraint/dependent_nodes.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <gtest/gtest.h>

namespace pliant::test {

/// Nodes on a screw with an axis that is fixed in space: with s = X - centre,
///
///   x = centre + R(theta) s + pitch theta axis,   theta = theta_ref + xi / size.
class ScrewJoint final : public DependentNodes {
 public:
  /// `axis`: of unit length; `pitch` [m/rad]. Collective.
  ScrewJoint(const NodeLayout& layout, std::vector<PetscInt> nodes, const Vector3<double>& centre,
             const Vector3<double>& axis, double pitch)
      : layout_(&layout), nodes_(std::move(nodes)), centre_(centre), axis_(axis), pitch_(pitch) {
    std::vector<PetscInt> mine;
    for (const PetscInt a : nodes_) mine.push_back(layout.global_node(a));
    hosts_ = {3 * gathered(layout.comm, mine).front()};
  }

  std::string description() const override { return "screw joints"; }
  std::span<const PetscInt> nodes() const override { return nodes_; }
  std::span<const PetscInt> hosts() const override { return hosts_; }
  void set_rigidity(Rigidity rigidity) override { ASSERT_EQ(rigidity, Rigidity::of_configurations); }
  bool is_symmetric() const override { return true; }

  void begin_stage(const StagePoint& /*stage*/, Vec q) override { reference_ = nearest_angle(q); }
  void begin_end_of_step(Vec q) override { reference_ = nearest_angle(q); }

  void put_displacements(std::span<const double> unknowns, Vec q) const override {
    const double theta = reference_ + unknowns[0] / size;
    put(q, [&](PetscInt a) {
      return Placement{{}, exponential(theta * axis_)}.displacement(arm(a)) + pitch_ * theta * axis_;
    });
  }
  void put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const override {
    columns[0] = (1.0 / size) * slope(reference_ + unknowns[0] / size, node);
  }
  void put_test_columns(std::span<const double> unknowns, PetscInt node,
                        std::span<Vector3<double>> columns) const override {
    put_columns(unknowns, node, columns);
  }
  std::vector<double> curvature(std::span<const double> unknowns, Vec f) const override {
    const ConstArrayView forces(f);
    double sum = 0.0;
    for (const PetscInt a : nodes_) {
      const Vector3<double> force = {forces[3 * a], forces[3 * a + 1], forces[3 * a + 2]};
      sum += pliant::dot(force, cross(axis_, slope(reference_ + unknowns[0] / size, a)));
    }
    return {sum / (size * size)};
  }

  std::vector<double> nearest_unknowns(Vec q) const override { return {size * (nearest_angle(q) - reference_)}; }
  std::vector<double> nearest_rates(Vec v) const override { return {size * nearest_spin(0.0, v)}; }

  void start_stage(const StagePoint& /*stage*/) const override {}
  void complete_step(const Step& step, Vec q, Vec v) const override {
    const double theta = nearest_angle(q);
    put(q, [&](PetscInt a) {
      return Placement{{}, exponential(theta * axis_)}.displacement(arm(a)) + pitch_ * theta * axis_;
    });
    restart(step, q, v);
  }
  void restart(const Step& /*step*/, Vec q, Vec v) const override {
    const double theta = nearest_angle(q), spin = nearest_spin(theta, v);
    put(v, [&](PetscInt a) { return spin * slope(theta, a); });
  }
  void subtract_given(Vec /*v*/) const override {}
  bool is_ideal() const override { return true; }

 private:
  static constexpr double size = 0.7;  // [m]

  Vector3<double> arm(PetscInt node) const { return layout_->position(node) - centre_; }
  /// dx / dtheta.
  Vector3<double> slope(double theta, PetscInt node) const {
    return cross(axis_, turn(exponential(theta * axis_), arm(node))) + pitch_ * axis_;
  }
  /// The angle of q where that lies on the screw, else one near it.
  double nearest_angle(Vec q) const {
    return pliant::dot(axis_, logarithm(nearest_placement_about(axis_, *layout_, nodes_, centre_, q).rotation));
  }
  /// omega of the least sum |v - omega dx/dtheta|^2.
  double nearest_spin(double theta, Vec v) const {
    std::array<double, 2> sums{};
    {
      const ConstArrayView velocities(v);
      for (const PetscInt a : nodes_) {
        const Vector3<double> velocity = {velocities[3 * a], velocities[3 * a + 1], velocities[3 * a + 2]};
        sums[0] += pliant::dot(slope(theta, a), velocity);
        sums[1] += pliant::dot(slope(theta, a), slope(theta, a));
      }
    }
    sum_in_place(layout_->comm, sums);
    return sums[0] / sums[1];
  }
  template <class Value>
  void put(Vec x, const Value& value) const {
    const ArrayView entries(x);
    for (const PetscInt a : nodes_) {
      const Vector3<double> at = value(a);
      for (std::size_t i = 0; i < 3; ++i) entries[3 * a + static_cast<PetscInt>(i)] = at[i];
    }
  }

  const NodeLayout* layout_;
  std::vector<PetscInt> nodes_, hosts_;
  Vector3<double> centre_, axis_;
  double pitch_;
  double reference_ = 0.0;
};

}  // namespace pliant::test
